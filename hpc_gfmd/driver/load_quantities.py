"""The quantities that a load may prescribe, and how each depends on the load: the first guess, the
straightened value, the predicted and the certified one. The area is in area_search.py."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, isfinite, log, prod
from typing import TYPE_CHECKING

from .area_search import AreaSearch
from .height_statistics import HeightStatistics
from .load_search import CALIBRATION, Errors, SecantSearch, Value

if TYPE_CHECKING:
    from ..certificate.certificate import Certificate
    from ..solvers.base import Progress, Solver
    from ..surface import Surface
    from .load import Load


class GapSearch(SecantSearch):
    """A search for the load that gives a mean gap. For attributes see `SecantSearch`."""

    usual = 0.4

    def guess(self, surface: Surface) -> float:
        """Guess x by the gap of self-affine walls, or of a single point that carries the load."""
        alone = (self.heights.top - self.target) / (surface.grid.a * self.heights.points)
        return max(-1 - 2 * self.target * surface.slope / surface.h_rms, log(alone))

    def straight(self, y: float) -> float:
        """Return log(log(top/y)), as the mean gap decreases like top exp(-c p0^s).

        -inf from y = top on (at most one point touches), inf for y <= 0.
        """
        if y <= 0:
            return inf
        return log(log(self.heights.top / y)) if y < self.heights.top else -inf

    def predicted(self, solver: Solver, progress: Progress, errors: Errors) -> Value | None:
        """Predict the mean gap by `progress.predicted`.

        Its error is that of the mean gap; at full contact that of the pressure if it is larger.
        """
        error = max(errors) if progress.contact == solver.N else errors[0]
        return (progress.predicted[1] * solver.grid.a, error) if progress.predicted else None

    def within(self, solver: Solver, progress: Progress, room: float) -> bool:
        """Return whether the error of the mean gap is below `room`, or limited by rounding."""
        estimate = progress.estimate
        if estimate is None:
            return True
        return estimate.gap < room or estimate.attainable[0] >= self.tolerance

    def certified(self, solver: Solver, certificate: Certificate) -> Value:
        """Return the certified mean gap and its error.

        The error is 0 if rounding errors keep it above the tolerance: iterations cannot help.
        """
        is_limited = certificate.attainable[0] >= self.tolerance
        error = 0.0 if is_limited else certificate.errors[1]
        return certificate.gap_mean * solver.grid.a, error


@dataclass
class OpeningSearch(GapSearch):
    """A search for a mean gap close to full contact, a power of (closes_at - p0)/p0.

    Call `begin_below` before the iterations, once the load of full contact is known.

    Attributes
    ----------
    opens : float
        Distance of p0 from `closes_at` at which a single open point would give this mean gap.
    """

    usual = 1.5
    from_full_contact = True

    opens: float = 0.0

    def begin_below(self, closes_at: float) -> None:
        """Set `closes_at`, the load of full contact, and p0 to closes_at - opens (half of it at
        least)."""
        self.closes_at = closes_at
        self.x = log(closes_at) + log(max(closes_at / self.opens - 1, 1.0))

    def straight(self, y: float) -> float:
        """Return log(top/y), which is linear in log(p0/(closes_at - p0))."""
        return log(self.heights.top / y) if y > 0 else inf


class ApproachSearch(SecantSearch):
    """A search for the load that gives an approach of the bodies. See `SecantSearch`."""

    usual = 0.8

    def guess(self, surface: Surface) -> float:
        """Guess x by the approach of a flat punch as large as the surface."""
        return log(self.target / max(surface.sizes))

    def straight(self, y: float) -> float:
        """Return log(y), as the approach is a power of the load."""
        return log(y) if y > 0 else -inf

    def predicted(self, solver: Solver, progress: Progress, errors: Errors) -> Value | None:
        """Return the approach of the solver's present displacement, and its relative error.

        Unlike the other searches it does not extrapolate to the converged solution. Collective.
        """
        grid = solver.grid
        heights = self.heights
        share = grid.N / grid.cell_points
        (total_gap,) = grid.comm.sum([solver.g.sum(dtype=float)])
        uniform = solver.p_cell / solver.elastic.multipliers.uniform
        y = (uniform - total_gap / grid.cell_points) * grid.a
        y += heights.top * share - heights.lowest * (1 - share)
        return y, _error_of_approach(y, progress.gap_mean * grid.a, *errors)

    def within(self, solver: Solver, progress: Progress, room: float) -> bool:
        """Return whether the error of the predicted approach is below `room`."""
        prediction = self._prediction(solver, progress)
        return prediction is None or prediction[1] < room

    def certified(self, solver: Solver, certificate: Certificate) -> Value:
        """Return the certified approach and its error."""
        a = solver.grid.a
        y = certificate.approach * a
        return y, _error_of_approach(y, certificate.gap_mean * a, *certificate.errors[1:])


def _error_of_approach(y: float, gap: float, gap_error: float, pressure_error: float) -> float:
    """Return the relative error of an approach y; infinite unless y > 0.

    gap: the mean gap, in the unit of y; gap_error, pressure_error: relative errors of the mean gap
    and of the pressure field.
    """
    return gap_error * gap / y + CALIBRATION.field * pressure_error if y > 0 else inf


SEARCHES: dict[str, type[SecantSearch]] = {
    "a_r": AreaSearch,
    "gap_mean": GapSearch,
    "approach": ApproachSearch,
}


def search_for(
    load: Load,
    surface: Surface,
    heights: HeightStatistics,
    tolerance: float,
    error_counts: bool,
    history: Sequence[dict[str, float]] = (),
    hardness: float | None = None,
) -> SecantSearch:
    """Make the search for the load that gives an area, a mean gap or an approach.

    Parameters
    ----------
    load : Load
        The prescribed quantity and its value.
    surface : Surface
        The surface.
    heights : HeightStatistics
        Statistics of the finest grid.
    tolerance : float
        Largest relative miss of the value.
    error_counts : bool
        Whether miss and error of the solution together must not exceed the tolerance.
    history : sequence of dict
        Loads that were solved before, the newest last: `p0`, in the program's unit, and the values
        that it gave, by quantity.
    hardness : float, optional
        The largest pressure, in the program's unit.

    Returns
    -------
    SecantSearch
        At its first load: extrapolated from `history`, or guessed without it. Nothing is solved.
    """
    value = load.value if load.quantity == "a_r" else load.value / surface.slope
    kind = SEARCHES[load.quantity]
    search = kind(
        value,
        tolerance,
        error_counts,
        heights,
        heights,
        closes_at=hardness or inf,
        slope=kind.usual,
    )
    if isinstance(search, AreaSearch):
        search.map_points = prod(surface.n) // prod(surface.grid.nominal)
    for solved in history:
        search.x = search.x_of(solved["p0"])
        if isfinite(search.x):
            search.secant(solved[load.quantity])
    if search.certified_before is None:
        search.x = search.guess(surface)
        return search
    x, f = search.certified_before
    way = search.straight(search.aim) - f
    if abs(way) > 4 * CALIBRATION.step * search.slope:  # what is near tells nothing of it
        search.slope = kind.usual
    search.x = x + way / search.slope
    return search
