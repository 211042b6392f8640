"""The search for the load that gives an area, a mean gap or an approach: a bracketed secant method
with inexact solves.

All three are monotone in the mean pressure p0, and the default solver goes on at another p0 without
a transform. So after every iteration, on every coarse grid, too, the load is changed where the
value that the solver predicts misses the target by more than the prediction may be wrong by.
Once the contact is solved the certified value counts: it bounds the load, and a secant, or the
middle of the bounds, leads on. What is missed and the error of the solution are together no more
than the accuracy asked for. Where bounds meet and the target stays between them the area jumps, as
in ordered walls whose asperities touch all at once: the nearer side is taken, and `note` says so.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import copysign, exp, inf, isfinite, log
from typing import TYPE_CHECKING, ClassVar

from .height_statistics import HeightStatistics
from .search import LoadSearch, area_may_be_met

if TYPE_CHECKING:
    from ..certificate.certificate import Certificate
    from ..operators.problem import Problem
    from ..solvers.base import Progress, Solver
    from ..surface import Surface


@dataclass(frozen=True)
class Calibration:
    """When a search changes the load, and how far.

    Measured on the areas, gaps and approaches of 24 walls of three spectra: the pairs that a search
    takes over those at the pressure that it finds. All but `jump` cost or save pairs only: what a
    search ends with is certified.

    Attributes
    ----------
    step : float
        Longest change of log p0 by a slope.
    steepest : float
        Largest slope of a straightened value that is believed, and 1 over the least.
    share : float
        Of the tolerance and of the error of a prediction: a predicted miss beyond it is corrected.
    coarse : float
        Relative miss up to which a coarse grid is content: it knows the value no better.
    jump : float
        Bounds nearer than half of it in log p0, or than half of the tolerance, enclose a jump.
    field : float
        Share of the error of the pressure field that counts towards that of an approach.
    trials, most : int
        Corrections by predictions on one grid; corrections in all.
    """

    step: float = log(2.0)
    steepest: float = 10.0
    share: float = 0.35
    coarse: float = 0.05
    jump: float = 1e-3
    field: float = 0.1
    trials: int = 5
    most: int = 60


CALIBRATION = Calibration()

Value = tuple[float, float]  # and its relative error
Errors = tuple[float, float]


def x_of(p0: float, closes_at: float | None) -> float:
    """Return the variable x of a search for p0, which is below closes_at where there is one."""
    return -log(1 / p0 - 1 / closes_at) if closes_at and isfinite(closes_at) else log(p0)


@dataclass
class SecantSearch(LoadSearch):
    """The state of a search: plain numbers. A subclass knows a quantity.

    target: an area, or a length over the unit of slopes; tolerance: relative; counts: whether the
    error of the solution counts towards it; finest, heights: of the finest grid and of this one;
    closes_at: p0 that closes the gap, or the hardness; x: log p0, or -log(1/p0 - 1/closes_at);
    slope: of the straightened value over x; low, high: (x, value) that bound the load; before: (x,
    straightened value) of the last certificate; trials: corrections by predictions on this grid;
    corrections: in all; looked: the last iteration that was looked at."""

    usual: ClassVar[float]  # slope, before anything is known
    steps: ClassVar[bool] = False  # whether the value may jump

    target: float
    tolerance: float
    counts: bool
    finest: HeightStatistics
    heights: HeightStatistics
    closes_at: float = inf
    x: float = 0.0
    slope: float = 1.0
    low: tuple[float, float] | None = None
    high: tuple[float, float] | None = None
    before: tuple[float, float] | None = None
    trials: int = 0
    corrections: int = 0
    looked: int = -1
    note: str | None = None

    # -- the quantity: what a subclass has to tell

    def guess(self, surface: Surface) -> float:
        """Guess log p0."""
        raise NotImplementedError

    def straight(self, y: float) -> float:
        """Make the value y one that rises about in proportion to x: -inf where nothing touches, inf
        where all does."""
        raise NotImplementedError

    def predicted(self, solver: Solver, progress: Progress, errors: Errors) -> Value | None:
        """Tell the value that is expected of a solution at this load, and its relative error.
        errors: estimated, of the mean gap and the pressure."""
        raise NotImplementedError

    def certified(self, solver: Solver, certificate: Certificate) -> Value:
        """Tell the value and its relative error."""
        raise NotImplementedError

    @property
    def aim(self) -> float:
        """The target, or what is nearest to it on this grid."""
        return self.target

    def miss(self, y: float) -> float:
        """Tell how far y is from the aim, relative."""
        return abs(y / self.aim - 1)

    # -- from grid to grid

    @property
    def p0(self) -> float:
        """The mean pressure, in the program's units."""
        x = min(max(self.x, -700.0), 700.0)  # no overflow
        return 1 / (exp(-x) + 1 / self.closes_at)

    def begin(self, problem: Problem | None = None) -> float:
        """Begin at the load of the grid before."""
        self.heights, self.trials, self.looked = self.finest, 0, -1
        if problem is not None:
            self.heights = HeightStatistics.of(problem.grid, problem.heights)
        self.low = self.high = self.before = self.note = None
        return self.p0

    def begin_at(self, p0: float) -> None:
        """Begin with this mean pressure, whose solution is about known."""
        self.x = x_of(p0, self.closes_at)

    # -- in the course of the iterations

    def near(self, solver: Solver, progress: Progress) -> bool:
        """Tell whether the value is as near as this grid knows it: not without the highest peak."""
        blind = self.heights.lowest > self.heights.top
        content = blind or self.trials == CALIBRATION.trials
        return content or not self._try(solver, progress, CALIBRATION.coarse)

    def adjust(self, solver: Solver, progress: Progress) -> bool:
        """Change the load where more than a share of the tolerance is missed or, in the end, where
        a value that may jump surely misses the target."""
        if solver.iterations == self.looked or self.note:
            return False
        self.looked = solver.iterations
        if self.trials < CALIBRATION.trials:
            return self._try(solver, progress, CALIBRATION.share * self.tolerance)
        found = self._prediction(solver, progress) if self.steps else None
        if not found or self.corrections == CALIBRATION.most:
            return False
        y, error = found
        miss = self.miss(y)
        if miss < max(error, self.tolerance) or not self.within(solver, progress, miss):
            return False
        self._bound(y)
        return self._step(y, miss, solver)

    def _try(self, solver: Solver, progress: Progress, least: float) -> bool:
        found = self._prediction(solver, progress)
        if found is None or self.miss(found[0]) <= max(least, CALIBRATION.share * found[1]):
            return False
        x = self.x + self._way(found[0])
        if (self.low and x <= self.low[0]) or (self.high and x >= self.high[0]):
            return False
        self.trials += 1
        return self._go(x, solver)

    def _prediction(self, solver: Solver, progress: Progress) -> Value | None:
        """Tell what the solver predicts, once it is far enough."""
        errors = progress.estimates if progress.finite else None
        if errors and errors[1] < CALIBRATION.step:
            return self.predicted(solver, progress, errors)
        return None

    def may_be_met(self, solver: Solver, progress: Progress, accuracy: float) -> bool:
        """Tell whether the certificate may find the target met, or has to say what is missed."""
        found = self._prediction(solver, progress) if self.counts and not self.note else None
        missed = self.miss(found[0]) if found else 0.0
        room = accuracy - missed if missed < accuracy else accuracy
        area_is_known = self.steps or area_may_be_met(solver, progress, accuracy)
        return area_is_known and self.within(solver, progress, room)

    def within(self, solver: Solver, progress: Progress, room: float) -> bool:
        """Tell whether the certificate may find the error of the value less than room."""
        raise NotImplementedError

    # -- once the contact is solved

    def learn(self, solver: Solver, certificate: Certificate) -> float:
        """Bound the load by a value that surely misses the target."""
        y, error = self.certified(solver, certificate)
        if self.note:
            self._side_of_jump(y)
        elif self.miss(y) > error:
            self._bound(y)
        if self.note:
            return 0.0 if self.x == self._nearer[0] else inf
        return (self.miss(y) + (error if self.counts else 0.0)) / self.tolerance

    def _bound(self, y: float) -> None:
        """Bound the load by the value y; where bounds meet and the target stays between them it
        jumps."""
        small, here = self.straight(y) < self.straight(self.aim), (self.x, y)
        low, high = (here, self.high) if small else (self.low, here)
        if low and high and low[0] >= high[0]:  # one of them was none
            low, high = (here, None) if small else (None, here)
        self.low, self.high, apart = low, high, max(CALIBRATION.jump, self.tolerance) / 2
        if self.steps and low and high and high[0] - low[0] < apart:
            self._tell(low[1], high[1])

    def _side_of_jump(self, y: float) -> None:
        """Put the certified value in place of a predicted one; begin anew where that was wrong."""
        here = (self.x, y)
        low, high = (here if b and b[0] == self.x else b for b in (self.low, self.high))
        self.low, self.high = low, high
        if low and high and low[1] < self.aim <= high[1]:
            self._tell(low[1], high[1])
        else:
            self.note = self.low = self.high = None
            self._bound(y)

    def _tell(self, below: float, above: float) -> None:
        self.note = f"a_r jumps from {below:.4g} to {above:.4g}: the nearer is taken"

    @property
    def _nearer(self) -> tuple[float, float]:
        bounds = [bound for bound in (self.low, self.high) if bound]
        return min(bounds, key=lambda bound: abs(bound[1] - self.aim))

    def correct(self, solver: Solver, certificate: Certificate, solved: bool) -> bool:
        """Go where a secant has the target, between the bounds; over a plateau twice as far."""
        y, error = self.certified(solver, certificate)
        if self.corrections == CALIBRATION.most or not (solved or self.miss(y) > error):
            return False
        return self._step(y, error, solver)

    def _step(self, y: float, error: float, solver: Solver) -> bool:
        if self.note:
            return self._go(self._nearer[0], solver)
        least, way = self.secant(y, error), self._way(y)
        x = self.x + copysign(max(abs(way), least), way)
        if self.low and self.high and not self.low[0] < x < self.high[0]:
            x = 0.5 * (self.low[0] + self.high[0])
        return self._go(x, solver)

    def secant(self, y: float, error: float = 0.0) -> float:
        """Learn the slope from the last two values; returns how far it is to go at least."""
        f, last = self.straight(y), self.before
        if not isfinite(f):
            return 0.0
        self.before = (self.x, f)
        if last is None or not abs(self.x - last[0]) * self.slope > error:
            return 0.0
        slope = (f - last[1]) / (self.x - last[0])
        if 1 / CALIBRATION.steepest < slope < CALIBRATION.steepest:
            self.slope = slope
        return 2 * abs(self.x - last[0]) if slope <= 1 / CALIBRATION.steepest else 0.0

    def _way(self, y: float) -> float:
        """Tell by how much x is to change: not at all where this grid cannot have the target."""
        wanted = self.straight(self.aim)
        way = (wanted - self.straight(y)) / self.slope
        return min(max(way, -CALIBRATION.step), CALIBRATION.step) if isfinite(wanted) else 0.0

    def _go(self, x: float, solver: Solver) -> bool:
        self.x, self.corrections = x, self.corrections + 1
        solver.continue_at(self.p0)
        return True
