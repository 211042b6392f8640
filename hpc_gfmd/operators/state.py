"""The state of a contact while it is solved: gap and pressure, which solver, wall and certificate
share. Each State changes in place, by

==========================  ==============================  ======================================
                            gap g                           pressure p
==========================  ==============================  ======================================
`Solver.start`              as given                        of the wall at g, by an FFT pair
`Solver.step`               g + s d                         p + s K d, and the new attraction
`Solver.step_ahead`         g + d                           stays: a certificate has to follow
`Solver.continue_at`        stays                           changes with p0, by a constant
`Wall.undeform, balance`    the whole body moves            `undeform` alone: p0 everywhere
`Wall.lower`                the whole body moves            the attraction at the new gap
`certify`                   g < 0 set to 0 (not in dents)   of the wall at g, by an FFT pair
`certify_pressure`          that of p, by an FFT pair       as given
`SaddleGuard.leave_saddle`  moves along the least stable    of the wall at g, by an FFT pair
                            mode
`Closing`                   moves beyond free edges         of the closed contact at another p0
==========================  ==============================  ======================================

Whatever takes g and p instead of a State only reads them. The solver makes the arrays, g perhaps of
the gap to start from. Its own memory is the last step d and the levels of its preconditioner; they
belong to the state of the last step. Certificates and stabilities overwrite the levels, and in low
memory a certificate in double precision takes the memory of d, too: the solver goes on after
`restart`, `after_certificate` or `after_stability`.
"""

from dataclasses import dataclass

import numpy as np

from ..parallel.grid import Grid


@dataclass(frozen=True)
class Stability:
    """The stability of a state with an attraction, and its least stable mode."""

    value: float  # computed s, an upper bound; 1 without attraction, below 0 at a saddle
    lowest: float  # smallest s that is likely, by the uncertainty of `value`; it divides the errors
    # Displacement e, local slab, normalised to <e, K e> = 1 and with a positive sum (the gap
    # opens); None if no open point is attracted.
    mode: np.ndarray | None
    pairs: float  # FFT pairs that the search took


@dataclass
class State:
    """Gap, pressure and load of a contact, and what is known of exactly these; the numbers are the
    same on all ranks.

    Attributes
    ----------
    grid : Grid
    g : array, local slab
        Gap: below 0 in dents, 0 or more elsewhere; beyond the surface the displacement.
    p : array, local slab
        Pressure, with an attraction that of the wall: p0 + K u + t.
    p0 : float
        Mean pressure over the surface. A spring changes it with the mean gap.
    uKu : float
        <u, K u>. `start` and certificates compute it, bpx updates it in every step.
    attracted : float
        Sum of the attraction t over all points.
    stability : Stability or None
        With an attraction, set by SaddleGuard; None as soon as the state changes.
    """

    grid: Grid
    g: np.ndarray
    p: np.ndarray
    p0: float
    uKu: float = 0.0
    attracted: float = 0.0
    stability: Stability | None = None

    @property
    def p_cell(self) -> float:
        """Mean of p0 over the whole grid, padding included."""
        return self.p0 * (self.grid.N / self.grid.cell_points)

    @property
    def wall_load(self) -> float:
        """Mean pressure that the wall bears over the surface: p0 plus the mean attraction."""
        return self.p0 + self.attracted / self.grid.N
