"""With an attraction: how a spring holds a mean gap or an approach ("Attraction" in
docs/method.md).

Under a dead load the bodies jump where gap and load decrease together. With a spring of stiffness k
(operators/problem.py) such states are stable if k exceeds dp0/dgap there. What is certified is the
equilibrium at the same end of the spring, whose mean gap and p0 differ from those of the state.

- An approach: k is the body's stiffness against a uniform pressure, so that the mean displacement
  and p0 add up to the same approach from the first step on.
- A mean gap: k is eight times the stiffness against a wave as long as the cell at first; a secant
  method moves the end of the spring. Where the contact jumps past the gap, it begins again with a
  stiffer spring: at an infinite k the state of least energy at that gap is stable.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..operators.elastic import Elastic
from .target import Target

if TYPE_CHECKING:
    from ..certificate.certificate import Certificate
    from ..operators.problem import Problem
    from ..solvers.base import Solver

# k of a mean gap at first, over the stiffness against a wave as long as the cell. Chosen: loads
# take 192, 155, 135, 109 and 125 pairs at 1, 4, 8, 16 and 32, but where several equilibria have the
# gap a stiffer spring may hold another one.
STIFF = 8.0
# Chosen; they cost or save pairs only, but for a search that needs more than MOST_TRIALS.
STIFFER = 4.0  # factor on k where the contact jumps past the target
HALVED = 0.5  # a smaller share of the miss before, on the other side, is no jump
SECANT = 1.25  # on dp0/dgap by a secant, for the error of p0 of a missed gap; measured: to 1.04
# share of the miss that is allowed below which the slope of the pressure need not be known; chosen
NEGLIGIBLE = 1e-3
MOST_TRIALS = 25  # positions of the end of the spring
JUMPS = "the contact jumps past the prescribed value: no equilibrium was found that is held there"


class Held(Target):
    """Holds the bodies by a spring, and moves its end until a mean gap or an approach is met.

    quantity: "gap_mean" or "approach"; target: its value in the program's unit. tolerance: of the
    miss over `unit`, which is |target|, but for an approach at least the range of the attraction.
    gap_at_touch: mean gap of undeformed bodies at touch; `touches`: whether the target is below.
    gap_at_start: where the solver starts, and starts again with a stiffer spring (local slab).
    `note`: JUMPS from a jump past the target on, until it is met.
    """

    is_sought = True

    def __init__(
        self,
        quantity: str,
        target: float,
        tolerance: float,
        p0: float,
        problem: Problem,
        gap_at_touch: float,
        gap_at_start: np.ndarray,
    ):
        self.quantity = quantity
        self.target = target
        self.touches = quantity == "gap_mean" and target < gap_at_touch
        # an approach may be 0
        self.unit = abs(target)
        if quantity == "approach":
            assert problem.attraction is not None
            self.unit = max(self.unit, float(problem.attraction.range))
        self.tolerance = tolerance
        self.gap_at_start = gap_at_start
        self.spring = spring_of(quantity, problem)
        self.begin_at(p0)

    @property
    def half_area(self) -> float:
        """A rough estimate of half the relative contact area: |p0|."""
        return abs(self.p0)

    def begin_at(self, p0: float) -> None:
        """Set `p0`, by which the spring holds the gap at the start: both tell where its end is."""
        self._p0_at_start = p0
        self.begin()

    def begin(self, problem: Problem | None = None) -> float:
        """Begin at the load and with the spring of the start, forget other attempts; return p0."""
        self.p0 = self._p0_at_start
        self._stiffness = self.spring
        self._end = 0.0  # by how much the end of the spring has moved, as a p0
        # of the solution before: this end, and by how much the bodies were too far apart
        self._before: tuple[float, float] | None = None
        self._trials = 0
        self.note = None
        return self.p0

    def _value(self, certificate: Certificate) -> float:
        return float(getattr(certificate, self.quantity))

    def _missed(self, certificate: Certificate) -> float:
        """Return by how much the bodies are too far apart."""
        missed = self._value(certificate) - self.target
        return missed if self.quantity == "gap_mean" else -missed

    def certificate_of(self, solver: Solver, certificate: Certificate) -> Certificate:
        """Return a certificate whose error of p0 is that at the prescribed gap: with what the gap
        misses and may be wrong by, at the slope of both.
        """
        if self.quantity != "gap_mean" or certificate.p0_error is None or not solver.state.p0:
            return certificate
        missed = self._missed(certificate)
        slope = self._slope(missed) or np.inf
        steepness = 1 / slope + self._stiffness_of(solver)
        of_gap = abs(missed) + certificate.errors[1] * certificate.gap_mean
        of_missed = abs(SECANT * steepness / solver.state.p0) * of_gap
        return replace(certificate, p0_error=certificate.p0_error + float(of_missed))

    def _slope(self, missed: float) -> float | None:
        """Return the change of the mean gap with the end of the spring, by the solution before."""
        if self._before is None or self._end == self._before[0]:
            return None
        return (missed - self._before[1]) / (self._end - self._before[0])

    def judge(self, solver: Solver, certificate: Certificate) -> float:
        """Store the solver's p0; return the miss over the tolerance less the gap's certified error
        (a tenth is left at least): met below 1. A gap is not met before its slope is known.
        """
        self.p0 = solver.state.p0
        error = certificate.errors[1] * certificate.gap_mean / self.unit
        room = max(self.tolerance - error, 0.1 * self.tolerance)
        missed = self._missed(certificate)
        left = abs(missed) / self.unit / room
        if self.quantity == "gap_mean" and left > NEGLIGIBLE and self._slope(missed) is None:
            left = max(left, 1.0)
        if left < 1:
            self.note = None
        return left

    def correct(self, solver: Solver, certificate: Certificate, solved: bool) -> bool:
        """Move the end of the spring by a secant, with a stiffer one after a jump past the target;
        False unless `solved`, and after MOST_TRIALS.
        """
        if not solved:
            return False
        missed = self._missed(certificate)
        before = self._before
        slope = self._slope(missed)
        self._before = (self._end, missed)
        if self._jumps(before, missed, certificate):
            return self._stiffen(solver)
        step = self._stiffness_of(solver) * missed
        if slope is not None and slope < 0:
            step = -missed / slope
        return self._move(solver, step)

    def _jumps(
        self, before: tuple[float, float] | None, missed: float, certificate: Certificate
    ) -> bool:
        """Return whether the contact has closed, or is as far on the other side of the target."""
        if self.quantity != "gap_mean":
            return False
        if certificate.gap_mean == 0 or before is None:
            return certificate.gap_mean == 0
        return missed * before[1] < 0 and abs(missed) > HALVED * abs(before[1])

    def bring_back(self, solver: Solver) -> bool:
        """Move the spring in by as much as separated bodies are too far apart, stiffer if they
        jumped; False after MOST_TRIALS.
        """
        if self._before is not None:
            return self._stiffen(solver)
        missed = solver.progress().gap_mean - self.target
        return self._move(solver, self._stiffness_of(solver) * missed)

    def _stiffen(self, solver: Solver) -> bool:
        """Begin again at the gap of the start with a stiffer spring and its mean pressure, by an
        FFT pair; False after MOST_TRIALS.
        """
        self.note = JUMPS
        self._before = None  # solutions with another spring say nothing of this one
        self._stiffness *= STIFFER
        gap = self.gap_at_start
        rows, points = solver.grid.inside
        (total,) = solver.grid.comm.sum([gap[:rows, :points].sum(dtype=float)])
        missed = total / solver.N - self.target
        return self._move(solver, self._stiffness_of(solver) * missed, self.gap_at_start)

    def _move(self, solver: Solver, step: float, gap: np.ndarray | None = None) -> bool:
        """Move the end of the spring by a step, which changes p0 at the present gap, or the start
        (`gap`); False after MOST_TRIALS.
        """
        self._trials += 1
        if self._trials > MOST_TRIALS:
            self.note = JUMPS
            return False
        self._end += step
        if gap is None:
            solver.continue_at(solver.state.p0 + step)
        else:
            solver.hold(self._stiffness)
            solver.state.p0 = self._p0_at_start + step
            solver.start(gap)
        return True

    def _stiffness_of(self, solver: Solver) -> float:
        """Return the change of p0 of a solver over that of the mean gap of its surface."""
        return self._stiffness * solver.grid.cell_points / solver.N


def spring_of(quantity: str, problem: Problem) -> float:
    """Return the stiffness of the spring that holds "gap_mean" or "approach" (collective)."""
    grid = problem.grid
    if quantity == "approach":
        return float(Elastic(grid, problem.body, problem.dtype).multipliers.uniform)
    longest = max(n * spacing for n, spacing in zip(grid.n, grid.spacings, strict=True))
    q = np.array([2 * np.pi * grid.a / longest])
    return STIFF * float(problem.body.stiffness(q, grid.a)[0])
