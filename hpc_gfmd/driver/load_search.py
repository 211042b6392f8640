"""The search for the load that gives an area, a mean gap or an approach: a bracketed secant method
with inexact solves.

All three are monotone in the mean pressure p0, and the default solver goes on at another p0 without
a transform. So after every iteration, on every coarse grid, too, the load is changed where the
value that the solver predicts misses the target by more than the prediction may be wrong by.
Once the contact is solved the certified value counts: it bounds the load, and a secant, or a load
between the bounds, leads on. What is missed and the error of the solution are together no more than
the accuracy asked for.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import copysign, exp, inf, isfinite, log
from typing import TYPE_CHECKING, ClassVar

from .bracket import Bound, Bracket
from .height_statistics import HeightStatistics
from .search import LoadSearch, area_may_be_met

if TYPE_CHECKING:
    from ..certificate.certificate import Certificate
    from ..operators.problem import Problem
    from ..solvers.base import Progress, Solver
    from ..surface import Surface


@dataclass(frozen=True)
class SearchCalibration:
    """When a search changes the load, and how far.

    Measured on the areas, gaps and approaches of 24 walls of three spectra: the pairs that a search
    takes over those at the pressure that it finds. They cost or save pairs only: what a search ends
    with is certified.

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
    field : float
        Share of the error of the pressure field that counts towards that of an approach.
    trials, corrections : int
        Most corrections by predictions on one grid; most corrections in all.
    """

    step: float = log(2.0)
    steepest: float = 10.0
    share: float = 0.35
    coarse: float = 0.05
    field: float = 0.1
    trials: int = 5
    corrections: int = 60


CALIBRATION = SearchCalibration()

Value = tuple[float, float]  # a value and its relative error
Errors = tuple[float, float]  # relative errors of the mean gap and of the pressure field


@dataclass
class SecantSearch(LoadSearch):
    """What a search knows: plain numbers. A subclass knows a quantity.

    The variable x is log p0, less what a single tall point carries alone, and rises to infinity
    where p0 comes to `closes_at`.

    Attributes
    ----------
    usual : float
        The slope of the straightened value over x before anything is known.
    target : float
        The area, or the length over the unit of slopes, that is asked for.
    tolerance : float
        Relative.
    error_counts : bool
        Whether the error of the solution counts towards the tolerance.
    finest, heights : HeightStatistics
        Of the finest grid, and of the present one.
    closes_at : float
        p0 that closes the gap, or the hardness; inf: neither is known.
    x : float
        The variable, at the present load.
    slope : float
        Of the straightened value over x.
    bracket : Bracket
        Certified values that bound the load.
    certified_before : pair of float, or None
        x and straightened value of the certificate before.
    trials, corrections : int
        Changes of the load: by predictions on this grid; in all.
    looked_at : int
        The last iteration at which a prediction was asked for.
    note : str or None
        What a user has to know of the load that was found.
    """

    usual: ClassVar[float]

    target: float
    tolerance: float
    error_counts: bool
    finest: HeightStatistics
    heights: HeightStatistics
    closes_at: float = inf
    x: float = 0.0
    slope: float = 1.0
    bracket: Bracket = field(default_factory=Bracket)
    certified_before: tuple[float, float] | None = None
    trials: int = 0
    corrections: int = 0
    looked_at: int = -1
    note: str | None = None

    # -- the quantity: what a subclass has to know

    def guess(self, surface: Surface) -> float:
        """Return a first x."""
        raise NotImplementedError

    def straight(self, y: float) -> float:
        """Return the straightened value of y, which rises about in proportion to x: -inf where
        nothing touches, inf where all does."""
        raise NotImplementedError

    def predicted(self, solver: Solver, progress: Progress, errors: Errors) -> Value | None:
        """Return the value that the solution at the present load is expected to have.

        Collective.

        Parameters
        ----------
        solver : Solver
            At the present mean pressure.
        progress : Progress
            Of the solver.
        errors : tuple of float
            Estimated relative errors of the mean gap and of the pressure field.

        Returns
        -------
        tuple of float, or None
            The value and its relative error; None where the solver cannot tell.
        """
        raise NotImplementedError

    def certified(self, solver: Solver, certificate: Certificate) -> Value:
        """Return the value that a certificate found.

        Parameters
        ----------
        solver : Solver
            At the present mean pressure.
        certificate : Certificate
            Of its gap.

        Returns
        -------
        tuple of float
            The value and its relative error.
        """
        raise NotImplementedError

    def within(self, solver: Solver, progress: Progress, room: float) -> bool:
        """Return whether the certificate may find the value accurate enough.

        Parameters
        ----------
        solver : Solver
            At the present mean pressure.
        progress : Progress
            Of the solver.
        room : float
            Relative error that the value may have.

        Returns
        -------
        bool
        """
        raise NotImplementedError

    @property
    def aim(self) -> float:
        """The target, or what is nearest to it on this grid."""
        return self.target

    def miss(self, y: float) -> float:
        """Return how far y is from the aim, relative."""
        return abs(y / self.aim - 1)

    def distance(self, solver: Solver, y: float) -> float:
        """Return how far a certified state is beyond the target.

        Collective.

        Parameters
        ----------
        solver : Solver
            At the certified state.
        y : float
            The value that was certified.

        Returns
        -------
        float
            See `Bound.distance`.
        """
        return self.straight(y) - self.straight(self.aim)

    # -- the variable

    @property
    def p0(self) -> float:
        """The mean pressure, in the program's units."""
        return self.p0_of(self.x)

    def p0_of(self, x: float) -> float:
        """Return the mean pressure at x."""
        x = min(max(x, -700.0), 700.0)  # no overflow
        return self._alone + 1 / (exp(-x) + 1 / (self.closes_at - self._alone))

    def x_of(self, p0: float) -> float:
        """Return x at a mean pressure: -inf where a single point carries it, inf beyond the
        largest."""
        shared = p0 - self._alone
        if shared <= 0:
            return -inf
        inverse = 1 / shared - 1 / (self.closes_at - self._alone)
        return -log(inverse) if inverse > 0 else inf

    @property
    def _alone(self) -> float:
        """Return p_1, the mean pressure that x = log(p0 - p_1) leaves out: 0 but for an area."""
        return 0.0

    # -- from grid to grid

    def measure(self, heights: Callable[[], HeightStatistics]) -> None:
        """Take over the statistics of the finest grid in the precision of the solver."""
        self.finest = heights()

    def begin(self, problem: Problem | None = None) -> float:
        """Begin at the load of the grid before."""
        self.heights = self.finest
        if problem is not None:
            self.heights = HeightStatistics.of(problem)
        self.trials = 0
        self.looked_at = -1
        self.bracket = Bracket()
        self.certified_before = None
        self.note = None
        return self.p0

    def begin_at(self, p0: float) -> None:
        """Begin with this mean pressure, whose solution is about known."""
        x = self.x_of(p0)
        if isfinite(x):
            self.x = x

    # -- in the course of the iterations

    def near(self, solver: Solver, progress: Progress) -> bool:
        """Return whether the value is as near as this grid knows it: not without the highest
        peak."""
        lacks_peak = self.heights.lowest > self.heights.top
        if lacks_peak or self.trials == CALIBRATION.trials:
            return True
        return not self._follow_prediction(solver, progress, CALIBRATION.coarse)

    def adjust(self, solver: Solver, progress: Progress) -> bool:
        """Change the load where more than a share of the tolerance is missed."""
        is_known = solver.iterations == self.looked_at
        if is_known or self.note or self.trials == CALIBRATION.trials:
            return False
        self.looked_at = solver.iterations
        return self._follow_prediction(solver, progress, CALIBRATION.share * self.tolerance)

    def _follow_prediction(self, solver: Solver, progress: Progress, allowed: float) -> bool:
        """Go where the prediction has the target, if it misses it by more than is allowed."""
        prediction = self._prediction(solver, progress)
        if prediction is None:
            return False
        y, error = prediction
        x = self.x + self._way(y)
        is_near = self.miss(y) <= max(allowed, CALIBRATION.share * error)
        if is_near or self.bracket.excludes(x):
            return False
        self.trials += 1
        return self._go(x, solver)

    def _prediction(self, solver: Solver, progress: Progress) -> Value | None:
        """Return what the solver predicts, once it is far enough."""
        errors = progress.estimates if progress.finite else None
        if errors and errors[1] < CALIBRATION.step:
            return self.predicted(solver, progress, errors)
        return None

    def may_be_met(self, solver: Solver, progress: Progress, accuracy: float) -> bool:
        """Return whether the certificate may find the target met, or has to say what is missed."""
        missed = self._predicted_miss(solver, progress)
        room = accuracy - missed if missed < accuracy else accuracy
        return area_may_be_met(solver, progress, accuracy) and self.within(solver, progress, room)

    def _predicted_miss(self, solver: Solver, progress: Progress) -> float:
        """Return how far the target is expected to be missed, 0 where that is not known."""
        if self.note or not self.error_counts:
            return 0.0
        prediction = self._prediction(solver, progress)
        return self.miss(prediction[0]) if prediction else 0.0

    # -- once the contact is solved

    def learn(self, solver: Solver, certificate: Certificate) -> float:
        """Bound the load by a value that surely misses the target."""
        y, error = self.certified(solver, certificate)
        missed = self.miss(y)
        if missed > error:
            too_small = self.straight(y) < self.straight(self.aim)
            self.bracket.add(Bound(self.x, y, self.distance(solver, y)), too_small)
        if not self.error_counts:
            return missed / self.tolerance
        # an error as large as the miss says nothing of the side
        return (missed + error) / max(missed, self.tolerance)

    def correct(self, solver: Solver, certificate: Certificate, solved: bool) -> bool:
        """Go where a secant has the target, between the bounds; over a plateau twice as far."""
        y, error = self.certified(solver, certificate)
        is_exhausted = self.corrections == CALIBRATION.corrections
        if is_exhausted or not (solved or self.miss(y) > error):
            return False
        over_plateau = self.secant(y, error)
        way = self._way(y)
        x = self.x + copysign(max(abs(way), over_plateau), way)
        if self.bracket.is_closed and self.bracket.excludes(x):
            x = self.bracket.between(0.0)
        return self._go(x, solver)

    def secant(self, y: float, error: float = 0.0) -> float:
        """Learn the slope from the last two certified values.

        Parameters
        ----------
        y : float
            The newest value, at the present x.
        error : float
            Its relative error: a change of x that explains no more is not used.

        Returns
        -------
        float
            By how much x has to change at least; more than 0 where the value hardly changes.
        """
        f = self.straight(y)
        before = self.certified_before
        if not isfinite(f):
            return 0.0
        self.certified_before = (self.x, f)
        if before is None or not abs(self.x - before[0]) * self.slope > error:
            return 0.0
        slope = (f - before[1]) / (self.x - before[0])
        if 1 / CALIBRATION.steepest < slope < CALIBRATION.steepest:
            self.slope = slope
        return 2 * abs(self.x - before[0]) if slope <= 1 / CALIBRATION.steepest else 0.0

    def _way(self, y: float) -> float:
        """Return by how much x is to change: not at all where this grid cannot have the target."""
        wanted = self.straight(self.aim)
        way = (wanted - self.straight(y)) / self.slope
        return min(max(way, -CALIBRATION.step), CALIBRATION.step) if isfinite(wanted) else 0.0

    def _go(self, x: float, solver: Solver) -> bool:
        self.x = x
        self.corrections += 1
        solver.continue_at(self.p0)
        return True
