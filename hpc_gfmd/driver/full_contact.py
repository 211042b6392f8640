"""Full contact is a start, a gap of 0: the certificate accepts it if no point is in tension.

A closed contact is linear in the load, p = p0 p1 + p_h, p1 being the pressure of a flat surface at
a mean of 1. The smallest load that closes it is max(-p_h/p1); with free edges iterations relax the
displacement beyond the surface.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from .target import DISTINCT, Target

if TYPE_CHECKING:
    from ..certificate.certificate import Certificate
    from ..parallel.grid import Grid
    from ..solvers.base import Progress, Solver


def tension_of(grid: Grid, p: np.ndarray, unit: np.ndarray | None = None) -> tuple[float, float]:
    """Return the largest tension max(-p/unit) of a closed contact and the rounding error of p;
    below 0 all points are pressed. Collective.
    """
    rows, points = grid.inside

    def extremes(i0: int, i1: int) -> tuple[float, float]:
        pressure = p[i0:i1, :points]
        scaled = pressure if unit is None else pressure / unit[i0:i1, :points]
        return -float(scaled.min()), float(np.abs(pressure).max())

    extremes_of_pieces = [(-np.inf, 0.0), *grid.by_rows(extremes, rows)]
    tension, largest = grid.comm.max(np.max(extremes_of_pieces, axis=0)).tolist()
    return tension, DISTINCT * float(np.finfo(p.dtype).eps) * largest


class Pressure(Target):
    """A prescribed mean pressure on a contact without attraction, which may close the gap."""

    def judge(self, solver: Solver, certificate: Certificate) -> float:
        """Return infinity if only rounding errors of double precision open a closed gap."""
        return 0.0 if self._missing(solver, certificate) is None else np.inf

    def correct(self, solver: Solver, certificate: Certificate, solved: bool) -> bool:
        """Press by these rounding errors."""
        missing = self._missing(solver, certificate)
        if missing is not None:
            solver.continue_at(solver.state.p0 + missing)
        return missing is not None

    def _missing(self, solver: Solver, certificate: Certificate) -> float | None:
        """Return the pressure that takes a closed gap's tension away, if within double precision's
        rounding errors.
        """
        is_closed = certificate.gap_mean == 0 and certificate.contact < solver.N
        if not is_closed or solver.problem.dtype != np.float64:
            return None
        tension, rounding = tension_of(solver.grid, solver.state.p)
        is_rounding = 0 <= tension <= DISTINCT * solver.problem_now.rounding
        return tension + rounding if is_rounding else None


class Closing(Target):
    """The smallest load that closes the gap, to a relative tolerance. unit: with free edges
    pressure and displacement (local slab) of a flat surface at a mean of 1.
    """

    is_sought = True
    from_full_contact = True
    closes = True

    def __init__(self, tolerance: float, unit: np.ndarray | None = None):
        super().__init__(1.0)
        self.tolerance = tolerance
        self.unit = unit

    def follow(self, solver: Solver, progress: Progress, coarse: bool = False) -> bool:
        """Go to the smallest load that closes the start; raise it later under tension. Not on
        coarse grids, which lack points.
        """
        lowest, rounding = self._lowest(solver)
        is_small = solver.iterations > 0 or lowest <= 2 * rounding
        if coarse or (lowest > 0 and is_small):
            return False
        more = 0.0 if self.unit is None else self.tolerance / 2 * (solver.state.p0 - lowest)
        return self._press(solver, rounding - lowest + more)

    def may_be_met(self, solver: Solver, progress: Progress, accuracy: float) -> bool:
        """True: a point that is about to open is no error of the area."""
        return True

    def certificate_of(self, solver: Solver, certificate: Certificate) -> Certificate:
        """Return a certificate without errors of area and gap if all is closed, as it has to be."""
        if certificate.contact < solver.N:
            return certificate
        _, _, pressure_error = certificate.errors
        return replace(certificate, errors=(0.0, 0.0, pressure_error))

    def judge(self, solver: Solver, certificate: Certificate) -> float:
        """Return 0 if all points are closed at the smallest such load, else infinity."""
        lowest, rounding = self._lowest(solver)
        is_smallest = lowest <= max(2 * rounding, self.tolerance * solver.state.p0)
        return 0.0 if certificate.contact == solver.N and is_smallest else np.inf

    def correct(self, solver: Solver, certificate: Certificate, solved: bool) -> bool:
        """Go to the smallest load that closes the gap of an accurate solution."""
        lowest, rounding = self._lowest(solver)
        if not solved or 0 < lowest < 2 * rounding:
            return False
        return self._press(solver, rounding - lowest)

    def _lowest(self, solver: Solver) -> tuple[float, float]:
        """Return by how much the load is above that of the first open point, and its rounding."""
        tension, rounding = tension_of(solver.grid, solver.state.p, self.unit)
        stored = solver.problem_now.rounding if self.unit is not None else 0.0
        return -tension, max(rounding, stored)

    def _press(self, solver: Solver, by: float) -> bool:
        """Raise the load, and go to the closed solution there, without an FFT; return True."""
        state = solver.state
        rows, points = state.grid.inside
        by = float(by)

        def press(i0: int, i1: int) -> None:
            if self.unit is None:
                state.p[i0:i1] += by
                return
            inner = max(rows - i0, 0)
            more = by * self.unit[i0:i1]
            state.p[i0:i1][:inner, :points] += more[:inner, :points]
            state.g[i0:i1][:inner, points:] += more[:inner, points:]
            state.g[i0:i1][inner:] += more[inner:]

        state.p0 += by
        state.grid.by_rows(press)
        solver.restart()
        return True
