"""The root-finder for a quantity that a load prescribes.

Area, mean gap and approach are monotonic in p0, and a solver goes on at another p0 without a
transform. One bracketed root-finder in x = log p0 finds all three: after every iteration, on every
grid, the value that the solver predicts moves x by a secant; once the contact is solved the
certified value does, and becomes a bound. See "Prescribed areas, gaps and approaches" in
docs/method.md.

A quantity y is two functions: its value (`predicted`, `certified`), and f(y), which is nearly
linear in x (`straight`); quantities.py and prescribed_area.py have them.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import exp, inf, isfinite, log, sqrt
from typing import TYPE_CHECKING, ClassVar, NamedTuple

from .target import Target, area_may_be_met

if TYPE_CHECKING:
    from ..certificate.certificate import Certificate
    from ..operators.problem import Problem
    from ..solvers.base import Progress, Solver
    from ..surface import Surface
    from .working_surface import WorkingSurface

# How far x moves. Chosen; they cost or save FFT pairs only, because the final value is certified.
STEP = log(2.0)  # largest change of x by a secant
STEEPEST = 10.0  # slopes of f over x are used between 1/STEEPEST and STEEPEST
SHARE = 0.35  # of the tolerance, and of the error of a prediction, above which x follows it
COARSE = 0.05  # relative miss that is accepted on a coarse grid, which cannot tell y better
TRIALS = 5  # changes of x by predictions on one grid
CORRECTIONS = 60  # all changes of x
# Relative difference of loads below which they are one. Chosen: rounding errors are 1e-14, and a
# single elastic point more takes 1e-9 of the load on the largest grids.
AT_ONE_LOAD = 1e-12
BEYOND = 1.5  # way beyond the end of a plateau, over the way from its last bound to this end

Value = tuple[float, float]  # a value and its relative error


class Bound(NamedTuple):
    """A certified load on one side: x, value, continuous distance (< 0: too small a load), and the
    x of the first load with this value, where a less accurate solution tells it.
    """

    x: float
    value: float
    distance: float
    plateau: float


def share_of_way(a: Bound, b: Bound, c: Bound | None) -> float:
    """Return where `distance` is 0 from the newest bound a to b, replaced by a: c; 0.5 if unknown.
    A secant, then inverse quadratic interpolation where trusted (Chandrupatla 1997,
    doi:10.1016/S0965-9978(96)00051-8).
    """
    bounds = [bound for bound in (a, b, c) if bound is not None]
    if len({bound.distance for bound in bounds if isfinite(bound.distance)}) < len(bounds):
        return 0.5
    if c is None:
        return a.distance / (a.distance - b.distance)
    xi = (a.x - b.x) / (c.x - b.x)
    phi = (a.distance - b.distance) / (c.distance - b.distance)
    if not (0 < xi < 1 and 1 - sqrt(1 - xi) < phi < sqrt(xi)):
        return 0.5
    of_b = a.distance / (b.distance - a.distance) * c.distance / (b.distance - c.distance)
    of_c = a.distance / (c.distance - a.distance) * b.distance / (c.distance - b.distance)
    return of_b + of_c * (c.x - a.x) / (b.x - a.x)


class Root(Target):
    """The root-finder for a quantity monotonic in p0. x = log(p0 - alone), infinite at `closes_at`
    (the hardness); `tolerance`: relative; `error_counts`: the solution's error counts too.
    """

    usual: ClassVar[float] = 1.0  # slope of f over x before any has been measured
    is_sought = True
    in_steps: ClassVar[bool] = False  # whether y goes in steps: a closed bracket is never left

    def __init__(
        self, value: float, working: WorkingSurface, earlier: Sequence[dict[str, float]] = ()
    ):
        self.value = value
        self.tolerance = working.settings.tolerance
        self.error_counts = working.settings.accuracy is not None
        self.finest = self.heights = working.heights
        self.closes_at = working.hardness
        self.slope = self.usual
        self.corrections = 0
        self._clear()
        self._go(self._first(working.surface, earlier))

    def _clear(self) -> None:
        """Forget what was found at other loads on this grid."""
        self.trials = 0
        self.note = None
        self.low: Bound | None = None
        self.high: Bound | None = None
        self.replaced: Bound | None = None  # the bound that the newest one has replaced
        self.newest_is_low = True
        self.extrapolated = False  # whether x is the end of a plateau between the bounds
        self.before: tuple[float, float] | None = None  # x and f of the last certificate

    def _first(self, surface: Surface, earlier: Sequence[dict[str, float]]) -> float:
        """Return x to begin with: extrapolated from loads that were solved before, or a guess."""
        for solved in earlier:
            self.x = self.x_of(solved["p0"])
            if isfinite(self.x):
                self._learn_slope(self.straight(solved[self.quantity]), 0.0)
        if self.before is None:
            return self.guess(surface)
        x, f = self.before
        way = self.straight(self.aim) - f
        if abs(way) > 4 * STEP * self.slope:  # what is near tells nothing of it
            self.slope = self.usual
        return x + way / self.slope

    # -- the quantity

    quantity: ClassVar[str]  # its name in the numbers of earlier loads

    def guess(self, surface: Surface) -> float:
        """Return the x to begin with if no load has been solved before."""
        raise NotImplementedError

    def straight(self, y: float) -> float:
        """Return f(y), nearly linear in x and rising; -inf without contact, inf at full contact."""
        raise NotImplementedError

    def predicted(self, solver: Solver, progress: Progress) -> Value | None:
        """Return y of the converged solution at the present load, and its relative error."""
        raise NotImplementedError

    def certified(self, solver: Solver, certificate: Certificate) -> Value:
        """Return y of a certificate, and its relative error."""
        raise NotImplementedError

    @property
    def aim(self) -> float:
        """The value to reach on the present grid."""
        return self.value

    def miss(self, y: float) -> float:
        """Return the relative distance of y from the aim."""
        return abs(y / self.aim - 1)

    def distance(self, solver: Solver, y: float) -> float:
        """Return a continuous function of the load that is 0 at the aim, below 0 under it."""
        return self.straight(y) - self.straight(self.aim)

    # -- the variable

    @property
    def alone(self) -> float:
        """The part of p0 that x leaves out."""
        return 0.0

    def p0_of(self, x: float) -> float:
        """Return the mean pressure at x."""
        x = min(max(x, -700.0), 700.0)  # no overflow
        return self.alone + 1 / (exp(-x) + 1 / (self.closes_at - self.alone))

    def x_of(self, p0: float) -> float:
        """Return x at a mean pressure: -inf up to `alone`, inf from `closes_at` on."""
        if p0 <= self.alone:
            return -inf
        inverse = 1 / (p0 - self.alone) - 1 / (self.closes_at - self.alone)
        return -log(inverse) if inverse > 0 else inf

    def _go(self, x: float) -> None:
        self.x = x
        self.p0 = self.p0_of(x)

    def learn_heights(self, working: WorkingSurface) -> None:
        self.finest = working.heights

    def begin(self, problem: Problem | None = None) -> float:
        self.heights = self.finest if problem is None else type(self.finest).of(problem)
        self._clear()
        self._go(self.x)
        return self.p0

    def begin_at(self, p0: float) -> None:
        x = self.x_of(p0)
        if isfinite(x):
            self._go(x)

    # -- the root-finder

    def propose(
        self, y: float, error: float, certified: bool, allowed: float = 0.0
    ) -> float | None:
        """Return the next x for the value y, within a relative error, or None to stay; a prediction
        within `allowed` is not followed.
        """
        f = self.straight(y)
        wanted = self.straight(self.aim)
        if certified:
            self._learn_slope(f, error)
        way = (wanted - f) / self.slope if isfinite(wanted) else 0.0
        x = self.x + min(max(way, -STEP), STEP)
        is_closed = self.low is not None and self.high is not None
        if not certified:
            is_near = self.miss(y) <= max(allowed, SHARE * error)
            if is_near or self.trials == TRIALS or not self._is_inside(x):
                return None
            self.trials += 1
        elif is_closed and (self.in_steps or not self._is_inside(x)):
            end = None if self.extrapolated else self.end_of_plateau()
            self.extrapolated = end is not None and self._is_inside(end)
            x = end if end is not None and self.extrapolated else self.between()
        elif not is_closed:
            end = self.end_of_plateau()
            x = x if end is None else self.x + BEYOND * (end - self.x)
        if x == self.x or self.corrections == CORRECTIONS:
            return None
        self.corrections += 1
        return x

    def _learn_slope(self, f: float, error: float) -> None:
        """Measure the slope of f over x by the last two certificates, beyond the error of f."""
        if not isfinite(f):
            return
        before = self.before
        self.before = self.x, f
        if before is None or not abs(self.x - before[0]) * self.slope > error:
            return
        slope = (f - before[1]) / (self.x - before[0])
        if 1 / STEEPEST < slope < STEEPEST:
            self.slope = slope

    def _is_inside(self, x: float) -> bool:
        above = self.low is None or x > self.low.x
        return above and (self.high is None or x < self.high.x)

    def bound(self, y: float, distance: float) -> None:
        """Make the present x a bound; one on the other side that contradicts it is dropped."""
        is_low = self.straight(y) < self.straight(self.aim)
        side, opposite = (self.low, self.high) if is_low else (self.high, self.low)
        if side is None or side.x != self.x:
            self.replaced = side
        if opposite is not None and (opposite.x <= self.x if is_low else opposite.x >= self.x):
            opposite = None
        is_same = side is not None and side.value == y
        new = Bound(self.x, y, distance, side.plateau if side and is_same else self.x)
        self.low, self.high = (new, opposite) if is_low else (opposite, new)
        self.newest_is_low = is_low

    def between(self) -> float:
        """Return x between the bounds where interpolation expects the target (`share_of_way`)."""
        assert self.low is not None
        assert self.high is not None
        newest, opposite = (self.low, self.high) if self.newest_is_low else (self.high, self.low)
        share = share_of_way(newest, opposite, self.replaced)
        margin = min(self._resolution() / (self.high.x - self.low.x), 0.5)
        return newest.x + min(max(share, margin), 1 - margin) * (opposite.x - newest.x)

    def _resolution(self) -> float:
        return 0.0

    def end_of_plateau(self) -> float | None:
        """Return x at the end of a plateau, on which the same points touch, or None."""
        new, old = self.low if self.newest_is_low else self.high, self.replaced
        if new is None or old is None or new.value != old.value:
            return None
        p0 = self.p0_of(new.x)
        way = p0 - self.p0_of(old.x)
        slope = (new.distance - old.distance) / way if way else 0.0  # 0: one number, rounded
        end = self.x_of(p0 - new.distance / slope) if slope > 0 else inf
        return end if isfinite(end) else None

    # -- what the loop asks

    def prediction(self, solver: Solver, progress: Progress) -> Value | None:
        """Return `predicted`; None while the error of the pressure is too large."""
        estimate = progress.estimate if progress.finite else None
        if estimate is None or not estimate.pressure < STEP:
            return None
        return self.predicted(solver, progress)

    def follow(self, solver: Solver, progress: Progress, coarse: bool = False) -> bool:
        is_closed = self.low is not None and self.high is not None
        prediction = None
        if self.note is None and not (self.in_steps and is_closed):
            prediction = self.prediction(solver, progress)
        if prediction is None:
            return False
        allowed = COARSE if coarse else SHARE * self.tolerance
        return self._continue(solver, self.propose(*prediction, certified=False, allowed=allowed))

    def _continue(self, solver: Solver, x: float | None) -> bool:
        """Let the solver go on at x, if there is one; return whether there is."""
        if x is None:
            return False
        self._go(x)
        solver.continue_at(self.p0)
        return True

    def may_be_met(self, solver: Solver, progress: Progress, accuracy: float) -> bool:
        missed = self._predicted_miss(solver, progress)
        room = accuracy - missed if missed < accuracy else accuracy
        return area_may_be_met(solver, progress, accuracy) and self.within(solver, progress, room)

    def _predicted_miss(self, solver: Solver, progress: Progress) -> float:
        """Return the miss that a prediction expects; 0 if it does not count."""
        counts = self.error_counts and self.note is None
        prediction = self.prediction(solver, progress) if counts else None
        return 0.0 if prediction is None else self.miss(prediction[0])

    def within(self, solver: Solver, progress: Progress, room: float) -> bool:
        """Return whether a certificate may find the error of y below `room`."""
        prediction = self.prediction(solver, progress)
        return prediction is None or prediction[1] < room

    def judge(self, solver: Solver, certificate: Certificate) -> float:
        y, error = self.certified(solver, certificate)
        missed = self.miss(y)
        if missed > error:
            self.bound(y, self.distance(solver, y))
        if not self.error_counts:
            return missed / self.tolerance
        # an error as large as the miss says nothing of the side
        return (missed + error) / max(missed, self.tolerance)

    def correct(self, solver: Solver, certificate: Certificate, solved: bool) -> bool:
        y, error = self.certified(solver, certificate)
        if not (solved or self.miss(y) > error):
            return False
        self.note = self._note_on_jump()
        if self.note is None:
            return self._continue(solver, self.propose(y, error, certified=True))
        return self._continue(solver, self._nearer_end())

    def _nearer_end(self) -> float | None:
        """Return x of the bound whose value is nearer to the aim; None at that one."""
        assert self.low is not None
        assert self.high is not None
        nearer = min((self.low, self.high), key=lambda bound: self.miss(bound.value))
        return None if nearer.x == self.x else nearer.x

    def _note_on_jump(self) -> str | None:
        """Return the note on a value that jumps past the aim at one load, else None."""
        if self.low is None or self.high is None or self.in_steps:
            return None
        below, above = (self.p0_of(bound.x) for bound in (self.low, self.high))
        if above - below > AT_ONE_LOAD * above:
            return None
        shares = sorted((self.low.value / self.aim, self.high.value / self.aim))
        return (
            f"{self.quantity} jumps at this load, from {shares[0]:.3g} to {shares[1]:.3g} times"
            " what is asked: all points in contact yield"
        )
