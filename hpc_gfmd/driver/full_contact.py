"""Full contact: its solution, u = -h, and the smallest load that closes the gap.

On a periodic surface this load is the largest tension of the closed contact at p0 = 0. With free
edges the closed solution is linear in the load: p = p0 p1 + p_h, where p1 is the pressure of a flat
surface at a mean of 1. The iterations then only relax the displacement beyond the surface. In their
course the load is corrected without a transform, to max(-p_h/p1), at which the last point is just
not in tension.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import DTypeLike

from ..certificate.certificate import Certificate, certify
from .target import ROUNDING, Target

if TYPE_CHECKING:
    from ..contact.contact import Contact
    from ..operators.problem import Problem
    from ..parallel.grid import Grid
    from ..solvers.base import Progress, Solver
    from .load import Load


def closed_contact(
    problem: Problem, dtype: DTypeLike = np.float64, dual: bool = False
) -> tuple[np.ndarray, np.ndarray, Certificate]:
    """Compute the state of full contact, g = 0, whether or not it is the solution.

    Collective, one FFT pair.

    Parameters
    ----------
    problem : Problem
        The contact, with stored heights and without padding.
    dtype : dtype
        Precision of the transforms.
    dual : bool
        Whether the certificate has the duality gap.

    Returns
    -------
    g, p : ndarray
        The gap, 0 everywhere, and its pressure, new local slabs.
    certificate : Certificate
        Certificate of this state, without errors. Points in tension do not count as contact, so it
        shows whether full contact is the solution.
    """
    g = np.zeros_like(problem.heights)
    p = np.empty_like(problem.heights)
    return g, p, certify(problem, g, p, dtype=dtype, dual=dual)


def tension_of(grid: Grid, p: np.ndarray, unit: np.ndarray | None = None) -> tuple[float, float]:
    """Return the largest tension, max(-p/unit) over the surface, of a closed contact.

    Collective.

    Parameters
    ----------
    grid : Grid
        Grid of the contact.
    p : ndarray
        Its pressure, local slab.
    unit : ndarray, optional
        Field that divides the pressure, local slab; 1 by default.

    Returns
    -------
    tension : float
        Below 0 if all points are pressed.
    rounding : float
        Rounding error of the pressure that may occur, not divided.
    """
    rows, points = grid.inside

    def extremes(i0: int, i1: int) -> tuple[float, float]:
        pressure = p[i0:i1, :points]
        scaled = pressure if unit is None else pressure / unit[i0:i1, :points]
        return -float(scaled.min()), float(np.abs(pressure).max())

    extremes_of_pieces = [(-np.inf, 0.0), *grid.by_rows(extremes, rows)]
    tension, largest = grid.comm.max(np.max(extremes_of_pieces, axis=0)).tolist()
    return tension, ROUNDING * float(np.finfo(p.dtype).eps) * largest


class Closing(Target):
    """The smallest load that closes the gap: the lowest pressure at a closed gap is just above 0.

    tolerance: largest relative error of the load. unit: with free edges the solution of a flat
    surface at a mean pressure of 1, its pressure on the surface and its displacement beyond (local
    slab), to be set before the iterations; None for a periodic surface.
    """

    is_sought = True
    from_full_contact = True

    def __init__(self, tolerance: float):
        super().__init__(1.0)
        self.tolerance = tolerance
        self.unit: np.ndarray | None = None

    def follow(self, solver: Solver, progress: Progress, coarse: bool = False) -> bool:
        """Raise the load if a point is in tension; not on coarse grids, which lack points."""
        lowest, rounding = self._lowest(solver)
        if coarse or lowest > 0:
            return False
        more = 0.0 if self.unit is None else self.tolerance / 2 * (solver.p0 - lowest)
        return self._press(solver, rounding - lowest + more)

    def may_be_met(self, solver: Solver, progress: Progress, accuracy: float) -> bool:
        """True: a point that is about to open is no error of the area."""
        return True

    def judge(self, solver: Solver, certificate: Certificate) -> float:
        """Return 0 if all points are closed at the smallest such load, else infinity."""
        lowest, rounding = self._lowest(solver)
        is_smallest = lowest <= max(2 * rounding, self.tolerance * solver.p0)
        return 0.0 if certificate.contact == solver.N and is_smallest else np.inf

    def correct(self, solver: Solver, certificate: Certificate, solved: bool) -> bool:
        """Go to the smallest load that closes the gap of an accurate solution."""
        lowest, rounding = self._lowest(solver)
        if not solved or 0 < lowest < 2 * rounding:
            return False
        return self._press(solver, rounding - lowest)

    def _lowest(self, solver: Solver) -> tuple[float, float]:
        """Return by how much the load is above that at which the first point opens, and the
        rounding error of that number."""
        tension, rounding = tension_of(solver.grid, solver.p, self.unit)
        stored = solver.problem_now.rounding if self.unit is not None else 0.0
        return -tension, max(rounding, stored)

    def _press(self, solver: Solver, by: float) -> bool:
        """Raise the load, and go to the closed solution there, without an FFT; return True."""
        rows, points = solver.grid.inside
        by = float(by)

        def press(i0: int, i1: int) -> None:
            if self.unit is None:
                solver.p[i0:i1] += by
                return
            inner = max(rows - i0, 0)
            more = by * self.unit[i0:i1]
            solver.p[i0:i1][:inner, :points] += more[:inner, :points]
            solver.g[i0:i1][:inner, points:] += more[:inner, points:]
            solver.g[i0:i1][inner:] += more[inner:]

        solver.p0 += by
        solver.grid.by_rows(press)
        solver.refresh()
        return True


def needs_double(contact: Contact, load: Load, problem: Problem) -> bool:
    """Return whether a load must be solved again, in double precision.

    It must if the solution in single precision stagnated or is not finite, if points are open
    but the mean gap is below rounding errors, or if all points are closed but rounding errors may
    hide a tension (unless the smallest load that closes it is sought). Collective.

    Parameters
    ----------
    contact : Contact
        The contact as solved in single precision.
    load : Load
        The load.
    problem : Problem
        The problem at the load's mean pressure.

    Returns
    -------
    bool
        The same on all ranks.
    """
    if contact.status in ("stagnated", "nonfinite") or contact.gap_is_rounding:
        return True
    if load.closes or contact.contact_points < contact.N:
        return False
    tension, _ = tension_of(contact.grid, contact.p)
    return tension > -ROUNDING * problem.rounding
