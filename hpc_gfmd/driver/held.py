"""With an attraction: how a spring holds a mean gap or an approach.

Under a dead load the bodies jump wherever the gap decreases while the load decreases, too. With a
spring of stiffness k (operators/problem.py) these states are stable if k exceeds the slope dp0/dgap
of the contact there. Each solution is an equilibrium at its own p0, so its certificate is the usual
one, but its stability includes the spring.

- An approach: k is the body's stiffness against a uniform pressure. The mean displacement and p0
  then always add up to the same approach, which does not change from the first step on.
- A mean gap: k is eight times the stiffness against a wave as long as the cell. A secant method
  moves the end of the spring until the mean gap is the prescribed one. Where the contact jumps
  past it from both sides, there is no such equilibrium: the search ends.
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

STIFF = 8.0  # k of a mean gap, over the stiffness against a wave as long as the cell
MOST_TURNS = 20  # solutions that miss the target on the other side than the one before
JUMPS = "the contact jumps past the prescribed value: no equilibrium was found that is held there"


class Held(LoadSearch):
    """A search that moves the end of a spring until a mean gap or an approach is met.

    Parameters
    ----------
    quantity : str
        "gap_mean" or "approach", attributes of a Certificate.
    target : float
        Its prescribed value, in the program's units.
    tolerance : float
        Largest error, relative to the target, or to the range of the attraction for an approach
        that is shorter than this range.
    p0 : float
        Mean pressure at the start.
    problem : Problem
        The contact on the finest grid.
    gap_at_touch : float
        Mean gap of undeformed bodies that just touch, in the program's unit.

    Attributes
    ----------
    spring : float
        Stiffness of the spring, see `spring_of`.
    touches : bool
        Whether the target is a mean gap at which the bodies touch.
    note : str or None
        JUMPS once the search has given up.
    unit : float
        Length to which `tolerance` is relative: |target|, for an approach no less than the range of
        the attraction.
    """

    def __init__(
        self,
        quantity: str,
        target: float,
        tolerance: float,
        p0: float,
        problem: Problem,
        gap_at_touch: float,
    ):
        self.quantity = quantity
        self.target = target
        self.touches = quantity == "gap_mean" and target < gap_at_touch
        # an approach may be 0
        self.unit = abs(target)
        if quantity == "approach" and problem.attraction is not None:
            self.unit = max(self.unit, float(problem.attraction.range))
        self.tolerance = tolerance
        self._p0 = p0
        self.spring = spring_of(quantity, problem)
        # of each solution: end of the spring as a p0, and by how much the bodies are too far apart
        self._solutions: list[tuple[float, float]] = []
        self._turns = 0

    @property
    def p0(self) -> float:
        """Mean pressure at the start, then that of the last certified solution."""
        return self._p0

    @property
    def half_area(self) -> float:
        """A rough estimate of half the relative contact area: |p0|."""
        return abs(self._p0)

    def begin_at(self, p0: float) -> None:
        """Set `p0`, the mean pressure at the start, which must belong to the gap at the start.

        The spring holds that gap by this pressure: the two determine where its end is.
        """
        self._p0 = p0

    def _value(self, certificate: Certificate) -> float:
        """Return the mean gap or approach that a certificate found."""
        return float(getattr(certificate, self.quantity))

    def learn(self, solver: Solver, certificate: Certificate) -> float:
        """Store the solver's p0; return the miss of the target over the tolerance (met below 1).

        The certified error of the mean gap is subtracted from the tolerance first, of which a tenth
        is left at least.
        """
        self._p0 = solver.p0
        error = certificate.errors[1] * certificate.gap_mean / self.unit
        room = max(self.tolerance - error, 0.1 * self.tolerance)
        return abs(self._value(certificate) - self.target) / self.unit / room

    def correct(self, solver: Solver, certificate: Certificate, solved: bool) -> bool:
        """Move the end of the spring to where a secant expects the target, and continue there.

        Does nothing and returns False unless `solved`, and after MOST_TURNS, of which `note` tells;
        changes p0 of the solver otherwise.
        """
        if not solved:
            return False
        if self._turns >= MOST_TURNS:
            self.note = JUMPS
            return False
        missed = self._value(certificate) - self.target
        missed = missed if self.quantity == "gap_mean" else -missed
        stiffness = self._stiffness_of(solver)
        end = solver.p0 - stiffness * certificate.gap_mean
        step = stiffness * missed
        if self._solutions:
            end_before, missed_before = self._solutions[-1]
            slope = (missed - missed_before) / (end - end_before) if end != end_before else 0.0
            step = -missed / slope if slope < 0 else step
            self._turns += missed * missed_before < 0
        self._solutions.append((end, missed))
        solver.continue_at(solver.p0 + step)
        return True

    def bring_back(self, solver: Solver) -> bool:
        """Move the end of the spring in by as much as separated bodies are too far apart.

        Changes p0 of the solver. Does nothing and returns False after MOST_TURNS, of which `note`
        tells.
        """
        self._turns += 1
        if self._turns > MOST_TURNS:
            self.note = JUMPS
            return False
        self._solutions.clear()  # the bodies apart are no solution
        missed = solver.progress().gap_mean - self.target
        solver.continue_at(solver.p0 + self._stiffness_of(solver) * missed)
        return True

    def _stiffness_of(self, solver: Solver) -> float:
        """Return the change of p0 of a solver over that of the mean gap of its surface."""
        return self.spring * solver.grid.cell_points / solver.N


def spring_of(quantity: str, problem: Problem) -> float:
    """Return the stiffness of the spring that holds a mean gap or an approach.

    Parameters
    ----------
    quantity : str
        "gap_mean" or "approach".
    problem : Problem
        The contact on the finest grid.

    Returns
    -------
    float
        Mean pressure of the cell per displacement, in the program's units. Collective for an
        approach.
    """
    grid = problem.grid
    if quantity == "approach":
        return float(Elastic(grid, problem.body, problem.dtype).multipliers.uniform)
    longest = max(n * spacing for n, spacing in zip(grid.n, grid.spacings, strict=True))
    q = np.array([2 * np.pi * grid.a / longest])
    return STIFF * float(problem.body.stiffness(q, grid.a)[0])
