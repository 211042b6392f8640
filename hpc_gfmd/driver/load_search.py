"""The search for the load that gives an area, a mean gap or an approach: a bracketed secant method
with inexact solves.

All three are monotone in the mean pressure p0, and the default solver continues at another p0
without a transform. So after every iteration, also on coarse grids, the load is changed if the
value that the solver predicts misses the target by more than a share of the prediction's error.
Once the contact is solved the certified value counts: it bounds the load, and the next load follows
from a secant, or lies between the bounds. The miss of the target and the error of the solution are
together no more than the requested accuracy.
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

    Measured on areas, gaps and approaches of 24 walls with three spectra, by the FFT pairs of a
    search over those of a solution at the pressure that it finds. The numbers cost or save pairs
    only, because the final value is certified.

    Attributes
    ----------
    step : float
        Largest change of log p0 by a secant.
    steepest : float
        Largest slope of the straightened value that is used; the smallest is 1/steepest.
    share : float
        Share of the tolerance, and of the error of a prediction, above which a predicted miss is
        corrected.
    coarse : float
        Relative miss that is accepted on a coarse grid, which cannot tell the value better.
    field : float
        Share of the error of the pressure field that counts towards the error of an approach.
    trials, corrections : int
        Largest number of changes of p0 by predictions on one grid, and of all changes together.
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
    """A bracketed secant search for p0; a subclass defines the quantity y that has a target.

    The variable is x = log(p0 - p_1), where p_1 is the load that a single tall point carries alone
    (0 unless an area is sought). Near `closes_at` x is stretched: it goes to infinity there. The
    secant is that of the straightened value f(y) (`straight`), which is nearly linear in x.

    Attributes
    ----------
    usual : float
        Slope of f over x that is used before any has been measured.
    target : float
        The prescribed value: a relative area, or a length over the unit of slopes.
    tolerance : float
        Largest relative miss of the target.
    error_counts : bool
        Whether miss and error of the solution together must not exceed the tolerance.
    finest, heights : HeightStatistics
        Statistics of the finest grid, and of the present one.
    closes_at : float
        An upper bound of p0: the load that closes the gap, or the hardness; inf if unknown.
    x : float
        The variable at the present load.
    slope : float
        Slope of f over x, as last measured.
    bracket : Bracket
        Certified loads that are too small or too large, on the present grid.
    certified_before : pair of float, or None
        x and f of the last certificate on this grid.
    trials, corrections : int
        Number of changes of the load by predictions on this grid, and of all changes.
    looked_at : int
        Number of the last iteration whose prediction was used.
    note : str or None
        A remark for the user on the load that was found.
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

    # -- the quantity: a subclass defines it

    def guess(self, surface: Surface) -> float:
        """Return the x to begin with if no load has been solved before. Changes nothing."""
        raise NotImplementedError

    def straight(self, y: float) -> float:
        """Return f(y), the straightened value, which rises nearly linearly with x.

        It is -inf for the y of no contact and inf for that of full contact.
        """
        raise NotImplementedError

    def predicted(self, solver: Solver, progress: Progress, errors: Errors) -> Value | None:
        """Predict the value y of the converged solution at the present load.

        Collective.

        Parameters
        ----------
        solver : Solver
            The iterating solver; it is not changed.
        progress : Progress
            Progress of the solver.
        errors : tuple of float
            Estimated relative errors of the mean gap and of the pressure field.

        Returns
        -------
        tuple of float, or None
            The value and its relative error; None if the solver makes no prediction.
        """
        raise NotImplementedError

    def certified(self, solver: Solver, certificate: Certificate) -> Value:
        """Return the value y of a certificate.

        Parameters
        ----------
        solver : Solver
            The solver, whose gap was certified.
        certificate : Certificate
            Its certificate.

        Returns
        -------
        tuple of float
            The value and its certified relative error.
        """
        raise NotImplementedError

    def within(self, solver: Solver, progress: Progress, room: float) -> bool:
        """Return whether a certificate may find the error of the value y small enough.

        Collective.

        Parameters
        ----------
        solver : Solver
            The iterating solver; it is not changed.
        progress : Progress
            Progress of the solver.
        room : float
            Largest relative error of the value.

        Returns
        -------
        bool
            The same on all ranks; True without an estimate.
        """
        raise NotImplementedError

    @property
    def aim(self) -> float:
        """The value sought on the present grid: the target, or what a coarse grid has instead."""
        return self.target

    def miss(self, y: float) -> float:
        """Return the relative distance |y/aim - 1| of a value from the aim."""
        return abs(y / self.aim - 1)

    def distance(self, solver: Solver, y: float) -> float:
        """Return a continuous measure of how far a certified state is beyond the aim.

        Collective.

        Parameters
        ----------
        solver : Solver
            The solver, at the certified state; it is not changed.
        y : float
            The certified value.

        Returns
        -------
        float
            Below 0 if the load is too small, see `Bound.distance`.
        """
        return self.straight(y) - self.straight(self.aim)

    # -- the variable

    @property
    def p0(self) -> float:
        """The mean pressure at the present x, in the program's unit."""
        return self.p0_of(self.x)

    def p0_of(self, x: float) -> float:
        """Return the mean pressure at x, the inverse of `x_of`."""
        x = min(max(x, -700.0), 700.0)  # no overflow
        return self._alone + 1 / (exp(-x) + 1 / (self.closes_at - self._alone))

    def x_of(self, p0: float) -> float:
        """Return x at a mean pressure.

        It is -inf up to the load that a single point carries, and inf from `closes_at` on.
        """
        shared = p0 - self._alone
        if shared <= 0:
            return -inf
        inverse = 1 / shared - 1 / (self.closes_at - self._alone)
        return -log(inverse) if inverse > 0 else inf

    @property
    def _alone(self) -> float:
        """The load p_1 in x = log(p0 - p_1); 0, unless an area is sought."""
        return 0.0

    # -- from grid to grid

    def measure(self, heights: Callable[[], HeightStatistics]) -> None:
        """Store the statistics of the finest grid in `finest`. Collective."""
        self.finest = heights()

    def begin(self, problem: Problem | None = None) -> float:
        """Begin on another grid at the present load: measure its heights, and clear the bracket.

        Returns p0. problem: with stored heights, on a coarse grid; None for the finest grid, whose
        statistics `measure` has stored. Collective.
        """
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
        """Set x to that of a mean pressure; does nothing if that is not finite."""
        x = self.x_of(p0)
        if isfinite(x):
            self.x = x

    # -- in the course of the iterations

    def near(self, solver: Solver, progress: Progress) -> bool:
        """Return whether p0 is near enough for this coarse grid; if not, change it. Collective.

        Called after every iteration on a coarse grid. p0 is near enough if the predicted miss is
        small or unknown, after five changes on this grid, and on a grid that lacks the highest
        peak. Otherwise x is set, and the solver goes on at the p0 that should meet the target.
        """
        lacks_peak = self.heights.lowest > self.heights.top
        if lacks_peak or self.trials == CALIBRATION.trials:
            return True
        return not self._follow_prediction(solver, progress, CALIBRATION.coarse)

    def adjust(self, solver: Solver, progress: Progress) -> bool:
        """Change p0 if the predicted miss exceeds a share of the tolerance; return whether it did.

        At most once per iteration, and not any more once there is a note.
        """
        is_known = solver.iterations == self.looked_at
        if is_known or self.note or self.trials == CALIBRATION.trials:
            return False
        self.looked_at = solver.iterations
        return self._follow_prediction(solver, progress, CALIBRATION.share * self.tolerance)

    def _follow_prediction(self, solver: Solver, progress: Progress, allowed: float) -> bool:
        """Go to where a secant has the aim, if the prediction misses it by more than `allowed`.

        Returns whether p0 of the solver has changed. It does not if the error of the prediction is
        large beside the miss, or if the new load is outside of the bracket.
        """
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
        """Return the prediction of the value; None while the error of the pressure is too large."""
        errors = progress.estimates if progress.finite else None
        if errors and errors[1] < CALIBRATION.step:
            return self.predicted(solver, progress, errors)
        return None

    def may_be_met(self, solver: Solver, progress: Progress, accuracy: float) -> bool:
        """Return whether a certificate now may find both the area and the value accurate enough.

        The error of the value may be what the predicted miss leaves of the accuracy. Collective.
        """
        missed = self._predicted_miss(solver, progress)
        room = accuracy - missed if missed < accuracy else accuracy
        return area_may_be_met(solver, progress, accuracy) and self.within(solver, progress, room)

    def _predicted_miss(self, solver: Solver, progress: Progress) -> float:
        """Return the relative miss that the prediction expects.

        0 without a prediction, with a note, and if the error of the solution does not count.
        """
        if self.note or not self.error_counts:
            return 0.0
        prediction = self._prediction(solver, progress)
        return self.miss(prediction[0]) if prediction else 0.0

    # -- once the contact is solved

    def learn(self, solver: Solver, certificate: Certificate) -> float:
        """Add the load to the bracket if it misses the target by more than the certified error.

        Returns the miss over the tolerance. If the error counts, it is instead the sum of miss and
        error over the tolerance, or over the miss if that is larger.
        """
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
        """Go to where a secant has the target, or between the bounds; twice as far on a plateau.

        Returns whether p0 of the solver has changed: not if the miss is within the error of a
        solution that is not accurate enough, nor after `corrections` changes.
        """
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
        """Set `slope` by the last two certified values, if their x differ enough.

        Stores the newest x and f(y) in `certified_before`. Does nothing if f(y) is infinite.

        Parameters
        ----------
        y : float
            The newest value, at the present x.
        error : float
            Its relative error. A change of x whose effect is not larger is not used.

        Returns
        -------
        float
            Smallest change of x that the next step should make: twice the last one if the value has
            hardly changed with it (a plateau), else 0.
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
        """Return the change of x, with its sign, by which a secant reaches the aim from y.

        At most `step`; 0 if the aim is that of full contact or of no contact.
        """
        wanted = self.straight(self.aim)
        way = (wanted - self.straight(y)) / self.slope
        return min(max(way, -CALIBRATION.step), CALIBRATION.step) if isfinite(wanted) else 0.0

    def _go(self, x: float, solver: Solver) -> bool:
        """Set x, and continue the solver at the p0 of x. Counts a correction; returns True."""
        self.x = x
        self.corrections += 1
        solver.continue_at(self.p0)
        return True
