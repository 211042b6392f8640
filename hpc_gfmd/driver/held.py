"""With an attraction: a mean gap or an approach that is held by a spring.

Under a dead load the bodies jump where the gap would fall although the load falls, too. Through a
spring of stiffness k (operators/problem.py) the states there are stable, as long as k is more than
the contact's own slope -dp0/dgap is below 0. Each solution is an equilibrium at its own p0, so
nothing changes in what certifies it but its stability, which counts the spring in.

- An approach: k is the body's stiffness against a uniform pressure. The mean displacement and p0
  then add up to the approach whatever they are, so it stays as it is from the first step on.
- A mean gap: k is that of a wave as long as the cell. The end of the spring is moved, by a secant
  method, until the gap is the one asked for.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..operators.elastic import Elastic
from .search import LoadSearch

if TYPE_CHECKING:
    from ..certificate.certificate import Certificate
    from ..operators.problem import Problem
    from ..solvers.base import Solver

STIFF = 8.0  # times the stiffness of a wave as long as the cell


class Held(LoadSearch):
    """Moves the end of the spring until a mean gap or an approach is met.

    Parameters
    ----------
    quantity : str
        "gap_mean" or "approach".
    target : float
        In the program's units.
    tolerance : float
        Relative; of an approach that is shorter than the range of the attraction, of that.
    p0 : float
        Mean pressure at the start.
    problem : Problem
        Of the finest grid.

    Attributes
    ----------
    spring : float
        Its stiffness.
    """

    def __init__(self, quantity: str, target: float, tolerance: float, p0: float, problem: Problem):
        self.quantity = quantity
        self.target = target
        # an approach may be 0
        self.unit = abs(target)
        if quantity == "approach" and problem.attraction is not None:
            self.unit = max(self.unit, float(problem.attraction.range))
        self.tolerance = tolerance
        self._p0 = p0
        self.spring = spring_of(quantity, problem)
        # of solutions: where the end of the spring is, in units of p0, and what is too much
        self._known: list[tuple[float, float]] = []

    @property
    def p0(self) -> float:
        """The present mean pressure."""
        return self._p0

    @property
    def half_area(self) -> float:
        """About half of the relative contact area: at least that of a small load."""
        return abs(self._p0)

    def begin_at(self, p0: float) -> None:
        """Begin with this mean pressure, that of the gap that the solver is given."""
        self._p0 = p0

    def _value(self, certificate: Certificate) -> float:
        return float(getattr(certificate, self.quantity))

    def learn(self, solver: Solver, certificate: Certificate) -> float:
        """Learn the present load, and how far its gap or approach is from the one asked for."""
        self._p0 = solver.p0
        error = certificate.errors[1] * certificate.gap_mean / self.unit
        room = max(self.tolerance - error, 0.1 * self.tolerance)
        return abs(self._value(certificate) - self.target) / self.unit / room

    def correct(self, solver: Solver, certificate: Certificate, solved: bool) -> bool:
        """Move the end of the spring once the solution is as accurate as asked."""
        if not solved:
            return False
        missed = self._value(certificate) - self.target
        missed = missed if self.quantity == "gap_mean" else -missed
        share = solver.grid.cell_points / solver.N
        end = solver.p0 - self.spring * share * certificate.gap_mean
        step = self.spring * share * missed
        if self._known:
            end_before, missed_before = self._known[-1]
            slope = (missed - missed_before) / (end - end_before) if end != end_before else 0.0
            step = -missed / slope if slope < 0 else step
        self._known.append((end, missed))
        solver.continue_at(solver.p0 + step)
        return True


def spring_of(quantity: str, problem: Problem) -> float:
    """Return the stiffness of the spring that holds a mean gap or an approach.

    Parameters
    ----------
    quantity : str
        "gap_mean" or "approach".
    problem : Problem
        Of the finest grid.

    Returns
    -------
    float
        Mean pressure of the cell over displacement, in the program's units.
    """
    grid = problem.grid
    if quantity == "approach":
        return float(Elastic(grid, problem.body, problem.dtype).multipliers.uniform)
    longest = max(n * spacing for n, spacing in zip(grid.n, grid.spacings, strict=True))
    q = np.array([2 * np.pi * grid.a / longest])
    return STIFF * float(problem.body.stiffness(q, grid.a)[0])
