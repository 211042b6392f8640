"""The least load that closes the gap everywhere.

Where all is closed the solution is linear in the load: p = p0 p1 + p_h, p1 being the pressure of a
flat surface at a mean of 1. So in the course of the iterations, which then only relax what is
beyond the surface, the load can be put right without a transform: to max(-p_h/p1), which just
leaves no point in tension. A surface that does not end has p1 = 1, and nothing to iterate.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..certificate.certificate import certify
from ..parallel import interrupt

if TYPE_CHECKING:
    from ..certificate.certificate import Certificate
    from ..operators.problem import Problem
    from ..solvers.base import Progress, Solver
    from ..surface import Surface
    from .sweep import Sweep

ROWS = 64  # looked at at a time
CLOSED = 8.0  # rounding errors that the pressures of a closed contact may have


def closing_pressure(problem: Problem) -> tuple[float, float]:
    """The load of a surface that does not end, and the FFT pairs that this took. problem: at any
    load. Collective."""
    g, p = np.zeros_like(problem.heights), np.empty_like(problem.heights)
    pairs = certify(problem, g, p).pairs
    tension, largest = problem.grid.comm.max(
        [-float(p.min(initial=np.inf)), float(np.abs(p).max(initial=0))]
    )
    return float(problem.p0 + tension + CLOSED * float(np.finfo(p.dtype).eps) * largest), pairs


def flat_solution(sweep: Sweep) -> tuple[np.ndarray, float]:
    """What a Closing needs of a surface that ends, solved for in its place, and the FFT pairs that
    this took. Collective."""
    surface, (rows, points) = sweep.surface, sweep.surface.grid.inside

    def flat(dtype: np.dtype) -> Surface:
        return replace(
            surface, h=np.zeros((rows, points), dtype), h_rms=0.0, g_rms=0.0, checksum=None
        )

    contact = type(sweep)(flat, sweep.settings, body=sweep.body).solve(
        1.0, lambda *_: interrupt.check(surface.grid.comm)
    )
    unit = contact.g
    unit[:rows, :points] = contact.p[:rows, :points]
    return unit, contact.pairs


class Closing:
    """Stands in for a search.Search. tolerance: relative, of the load; unit: the solution for a
    flat surface at a mean pressure of 1, local slab: the pressure on the surface, the displacement
    beyond it; None where the surface does not end."""

    kind, note, may_be_met, p0 = "closing", None, True, 1.0

    def __init__(self, tolerance: float, unit: np.ndarray | None):
        self.tolerance, self.unit = tolerance, unit

    def adjust(self, solver: Solver, progress: Progress, known: bool) -> bool:
        """Change the load of the solver where points are in tension or, if its solution is `known`
        as accurately as asked, none nearly is; returns whether."""
        lowest, rounding = self._lowest(solver)
        if lowest > 0 and (not known or lowest < 2 * rounding):
            return False
        self._press(
            solver,
            rounding
            - lowest
            + (0.0 if known or self.unit is None else self.tolerance / 2 * (solver.p0 - lowest)),
        )
        return True

    def met(self, solver: Solver, certificate: Certificate) -> bool:
        """Whether the certificate finds all closed, and the load the least."""
        lowest, rounding = self._lowest(solver)
        return certificate.contact == solver.N and lowest <= max(
            2 * rounding, self.tolerance * solver.p0
        )

    def correct(self, solver: Solver, certificate: Certificate, sure: bool) -> bool:
        """As `adjust`, to the pressure of the certificate."""
        return self.adjust(solver, solver.progress(), sure)

    def _lowest(self, solver: Solver) -> tuple[float, float]:
        """The load beyond that at which the first point opens, and its rounding error.
        Collective."""
        (rows, points), tension, largest = solver.grid.inside, -np.inf, 0.0
        for i in range(0, rows, ROWS):
            p = solver.p[i : min(i + ROWS, rows), :points]
            own = p if self.unit is None else p / self.unit[i : i + len(p), :points]
            tension, largest = (
                max(tension, -float(own.min())),
                max(largest, float(p.max()), -float(p.min())),
            )
        tension, largest = solver.grid.comm.max([tension, largest])
        stored = solver.problem_now.rounding if self.unit is not None else 0.0
        return -float(tension), max(CLOSED * float(np.finfo(solver.p.dtype).eps) * largest, stored)

    def _press(self, solver: Solver, by: float) -> None:
        """Go to a load that is so much larger, and to its solution. Collective."""
        (rows, points), by = solver.grid.inside, float(by)
        solver.p0 += by
        for i, (g, p) in enumerate(zip(solver.g, solver.p)):
            inner = points if i < rows else 0
            p[:inner] += by if self.unit is None else by * self.unit[i, :inner]
            g[inner:] += 0.0 if self.unit is None else by * self.unit[i, inner:]
        solver.correct_load(solver.p0) if solver.iterations else solver.refresh()
