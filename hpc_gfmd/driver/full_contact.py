"""The least load that closes the gap of a surface that ends.

Where all is closed the solution is linear in the load: p = p0 p1 + p_h, p1 being the pressure of a
flat surface at a mean of 1. So in the course of the iterations, which then only relax what is
beyond the surface, the load is put right without a transform: to max(-p_h/p1), which just leaves no
point in tension.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .load import GivenLoad

if TYPE_CHECKING:
    from ..certificate.certificate import Certificate
    from ..solvers.base import Progress, Solver

ROWS = 64  # looked at at a time
CLOSED = 8.0  # rounding errors that the pressures of a closed contact may have


class FullContact(GivenLoad):
    """A search for that load. tolerance: relative, of the load; unit: the solution for a flat
    surface at a mean pressure of 1, local slab: the pressure on the surface, the displacement
    beyond it; None where the surface does not end."""

    from_full_contact = True
    given = False

    def __init__(self, tolerance: float, unit: np.ndarray | None, p0: float = 1.0):
        super().__init__(p0, closes=True)
        self.tolerance, self.unit, self.known = tolerance, unit, False

    def numbers(self) -> dict[str, Any]:
        """What makes a checkpoint: there is no other state."""
        return {"kind": "full contact"}

    def adjust(self, solver: Solver, progress: Progress) -> bool:
        """Change the load where points are in tension."""
        lowest, rounding = self._lowest(solver)
        if lowest > 0:
            return False
        more = 0.0 if self.unit is None else self.tolerance / 2 * (solver.p0 - lowest)
        return self._press(solver, rounding - lowest + more)

    def may_be_met(self, solver: Solver, progress: Progress, accuracy: float) -> bool:
        """A point that is about to open is no error."""
        return True

    def learn(self, solver: Solver, certificate: Certificate) -> float:
        """All is to be closed, and the load the least."""
        lowest, rounding = self._lowest(solver)
        least = lowest <= max(2 * rounding, self.tolerance * solver.p0)
        return 0.0 if certificate.contact == solver.N and least else np.inf

    def correct(self, solver: Solver, certificate: Certificate, solved: bool) -> bool:
        """Go to the least load, once it is known."""
        lowest, rounding = self._lowest(solver)
        if not solved or 0 < lowest < 2 * rounding:
            return False
        return self._press(solver, rounding - lowest)

    def _lowest(self, solver: Solver) -> tuple[float, float]:
        """The load beyond that at which the first point opens, and its rounding error.
        Collective."""
        (rows, points), tension, largest = solver.grid.inside, -np.inf, 0.0
        for i in range(0, rows, ROWS):
            p = solver.p[i : min(i + ROWS, rows), :points]
            own = p if self.unit is None else p / self.unit[i : i + len(p), :points]
            tension = max(tension, -float(own.min()))
            largest = max(largest, float(p.max()), -float(p.min()))
        tension, largest = solver.grid.comm.max([tension, largest])
        stored = solver.problem_now.rounding if self.unit is not None else 0.0
        return -float(tension), max(CLOSED * float(np.finfo(solver.p.dtype).eps) * largest, stored)

    def _press(self, solver: Solver, by: float) -> bool:
        """Go to a load that is so much larger, and to its solution. Collective."""
        (rows, points), by = solver.grid.inside, float(by)
        solver.p0 += by
        for i, (g, p) in enumerate(zip(solver.g, solver.p)):
            inner = points if i < rows else 0
            p[:inner] += by if self.unit is None else by * self.unit[i, :inner]
            g[inner:] += 0.0 if self.unit is None else by * self.unit[i, inner:]
        solver.correct_load(solver.p0) if solver.iterations else solver.refresh()
        return True
