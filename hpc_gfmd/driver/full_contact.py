"""Full contact: its solution, u = -h, and the least load that closes the gap.

On a surface that does not end the latter is the largest tension without any load. On one that ends
the solution is linear in the load where all is closed: p = p0 p1 + p_h, p1 being the pressure of a
flat surface at a mean of 1. So in the course of the iterations, which then only relax what is
beyond the surface, the load is put right without a transform: to max(-p_h/p1), which just leaves no
point in tension.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import DTypeLike

from ..certificate.certificate import Certificate, certify
from .search import LoadSearch

if TYPE_CHECKING:
    from ..contact.contact import Contact
    from ..operators.problem import Problem
    from ..parallel.grid import Grid
    from ..solvers.base import Progress, Solver
    from .load import Load

CLOSED = 8.0  # rounding errors that the pressures of a closed contact may have


def closed_contact(
    problem: Problem, dtype: DTypeLike = np.float64, dual: bool = False
) -> tuple[np.ndarray, np.ndarray, Certificate]:
    """Return full contact, whether or not it is the solution.

    Collective.

    Parameters
    ----------
    problem : Problem
        With stored heights, on a surface that does not end.
    dtype : dtype
        Precision of the certificate.
    dual : bool
        Whether it has to give the duality gap.

    Returns
    -------
    g, p : ndarray
        The gap, 0 everywhere, and its pressure, local slabs.
    certificate : Certificate
        Points in tension do not count as contact.
    """
    g = np.zeros_like(problem.heights)
    p = np.empty_like(problem.heights)
    return g, p, certify(problem, g, p, dtype=dtype, dual=dual)


def tension_of(grid: Grid, p: np.ndarray, unit: np.ndarray | None = None) -> tuple[float, float]:
    """Return the largest tension of a closed contact.

    Collective.

    Parameters
    ----------
    grid : Grid
        Of the contact.
    p : ndarray
        Its pressure, local slab.
    unit : ndarray, optional
        By which the pressure is divided, local slab.

    Returns
    -------
    tension : float
        Below 0 where all points are pressed.
    rounding : float
        Rounding error of the pressure.
    """
    rows, points = grid.inside

    def extremes(i0: int, i1: int) -> tuple[float, float]:
        pressure = p[i0:i1, :points]
        scaled = pressure if unit is None else pressure / unit[i0:i1, :points]
        return -float(scaled.min()), float(np.abs(pressure).max())

    extremes_of_pieces = [(-np.inf, 0.0), *grid.by_rows(extremes, rows)]
    tension, largest = grid.comm.max(np.max(extremes_of_pieces, axis=0)).tolist()
    return tension, CLOSED * float(np.finfo(p.dtype).eps) * largest


class ClosingSearch(LoadSearch):
    """A search for the least load that closes the gap.

    Attributes
    ----------
    tolerance : float
        Relative, of the load.
    unit : ndarray or None
        The solution for a flat surface at a mean pressure of 1, local slab: the pressure on the
        surface, the displacement beyond it. To be set before the iterations where the surface ends;
        None where it does not.
    """

    from_full_contact = True

    def __init__(self, tolerance: float):
        self.tolerance = tolerance
        self.unit: np.ndarray | None = None
        self._p0 = 1.0

    @property
    def p0(self) -> float:
        """The mean pressure to begin with; in the end the solver's is the least."""
        return self._p0

    def begin_at(self, p0: float) -> None:
        """Begin with this mean pressure."""
        self._p0 = p0

    def adjust(self, solver: Solver, progress: Progress) -> bool:
        """Change the load where points are in tension.

        Parameters
        ----------
        solver : Solver
            At the present mean pressure.
        progress : Progress
            Of the solver.

        Returns
        -------
        bool
            Whether the load has changed.
        """
        lowest, rounding = self._lowest(solver)
        if lowest > 0:
            return False
        more = 0.0 if self.unit is None else self.tolerance / 2 * (solver.p0 - lowest)
        return self._press(solver, rounding - lowest + more)

    def may_be_met(self, solver: Solver, progress: Progress, accuracy: float) -> bool:
        """Return True: a point that is about to open is no error of the area.

        Parameters
        ----------
        solver : Solver
            At the present mean pressure.
        progress : Progress
            Of the solver.
        accuracy : float
            As requested.

        Returns
        -------
        bool
            True.
        """
        return True

    def learn(self, solver: Solver, certificate: Certificate) -> float:
        """Return 0 once every point is closed at the smallest such load, else infinity.

        Parameters
        ----------
        solver : Solver
            At the present mean pressure.
        certificate : Certificate
            Of its gap.

        Returns
        -------
        float
            How far the target is missed.
        """
        lowest, rounding = self._lowest(solver)
        is_smallest = lowest <= max(2 * rounding, self.tolerance * solver.p0)
        return 0.0 if certificate.contact == solver.N and is_smallest else np.inf

    def correct(self, solver: Solver, certificate: Certificate, solved: bool) -> bool:
        """Go to the smallest load that closes the gap, once it is known.

        Parameters
        ----------
        solver : Solver
            At the present mean pressure.
        certificate : Certificate
            Of its gap.
        solved : bool
            Whether the solution at the present load is as accurate as asked.

        Returns
        -------
        bool
            Whether the load has changed.
        """
        lowest, rounding = self._lowest(solver)
        if not solved or 0 < lowest < 2 * rounding:
            return False
        return self._press(solver, rounding - lowest)

    def _lowest(self, solver: Solver) -> tuple[float, float]:
        """Return the load beyond that at which the first point opens, and its rounding error.
        Collective."""
        tension, rounding = tension_of(solver.grid, solver.p, self.unit)
        stored = solver.problem_now.rounding if self.unit is not None else 0.0
        return -tension, max(rounding, stored)

    def _press(self, solver: Solver, by: float) -> bool:
        """Go to a load that is so much larger, and to its solution. Collective."""
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
    """Return whether single precision turned out to be too little for a load.

    A gap that is closed everywhere is so where the smallest pressure is more than rounding errors,
    unless the load is to be the least that closes it. Collective.

    Parameters
    ----------
    contact : Contact
        As found in single precision.
    load : Load
        What was asked for.
    problem : Problem
        At its mean pressure.

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
    return tension > -CLOSED * problem.rounding
