"""What a load prescribes: a mean pressure p0, or a quantity whose p0 is found while it is solved.

Area, mean gap and approach are monotonic in p0, and a solver goes on at another p0 without a
transform. One bracketed root-finder in x = log p0 finds all three: after every iteration, on every
grid, the value that the solver predicts moves x by a secant; once the contact is solved the
certified value does, and becomes a bound. See "Prescribed areas, gaps and approaches" in
docs/method.md.

A quantity y is two functions: its value (`predicted`, `certified`), and f(y), which is nearly
linear in x (`straight`).
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, erf, exp, floor, hypot, inf, isfinite, log, prod, sqrt
from statistics import NormalDist
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np

from ..operators.selection import nth_smallest

if TYPE_CHECKING:
    from ..certificate.certificate import Certificate
    from ..operators.problem import Problem
    from ..parallel.comm import Comm
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
BEYOND = 1.5  # way beyond the end of a plateau, over the way from its last bound to this end
POINT = 1.001  # points by which an area may always be missed
NEARLY_CLOSED = 0.2  # `opening_load` below which a gap is sought from full contact (0.3 to 20)
FIELD = 0.1  # share of the error of the pressure field that counts as error of an approach
ROUNDING = 8.0  # factor on rounding errors: smaller differences of pressures count as none

Value = tuple[float, float]  # a value and its relative error


class Target:
    """A prescribed mean pressure. Subclasses change it while a solver iterates.

    The loop (drive.py) calls `follow` after every iteration on every grid, `judge` and then
    `correct` after every certificate. Numbers are in the program's units, equal on all ranks; all
    methods are collective.
    """

    is_sought = False  # whether p0 is found by iterating
    note: str | None = None  # a remark for the user on the load that was found
    needs_double = False  # whether single precision cannot find the load, as far as known
    from_full_contact = False  # whether the iterations start from a gap of 0
    spring = 0.0  # stiffness of the spring that presses the body; 0: a dead load
    touches = False  # whether bodies that come apart have to be brought back

    def __init__(self, p0: float):
        self.p0 = p0

    @property
    def half_area(self) -> float:
        """An estimate of half the relative contact area; p0 is right at light loads."""
        return self.p0

    def measure(self, working: WorkingSurface) -> None:
        """Learn what is needed of the heights in the precision of the solver."""

    def begin(self, problem: Problem | None = None) -> float:
        """Begin on the grid of a coarse problem, or on the finest grid (None); return p0."""
        return self.p0

    def begin_at(self, p0: float) -> None:
        """Set the mean pressure to begin with."""
        self.p0 = p0

    def agree(self, comm: Comm) -> None:
        """Copy the state of this target from rank 0 to all ranks."""
        vars(self).update(comm.bcast(vars(self)))

    def follow(self, solver: Solver, progress: Progress, coarse: bool = False) -> bool:
        """Go to another load if the converged solution at this one would probably miss the target.

        Returns whether the load of the solver has changed. coarse: on a coarse grid.
        """
        return False

    def may_be_met(self, solver: Solver, progress: Progress, accuracy: float) -> bool:
        """Return whether a certificate may find area and target accurate enough.

        This takes a pass over all points. True without estimated errors.
        """
        return area_may_be_met(solver, progress, accuracy)

    def judge(self, solver: Solver, certificate: Certificate) -> float:
        """Return by how much a certificate misses the target, over what is allowed."""
        return 0.0

    def correct(self, solver: Solver, certificate: Certificate, solved: bool) -> bool:
        """Go to another load after a certificate that missed the target, which `judge` has seen.

        Returns whether the load of the solver has changed. solved: whether the solution is as
        accurate as asked.
        """
        return False

    def bring_back(self, solver: Solver) -> bool:
        """Press bodies that have come apart together again; return False to give up."""
        return False


def area_may_be_met(solver: Solver, progress: Progress, accuracy: float) -> bool:
    """Return whether a certificate may find the area accurate enough; True without an estimate."""
    estimate = progress.estimate
    return estimate is None or solver.expected_area(estimate) < accuracy


class Bound(NamedTuple):
    """A certified load on one side of the target: x, its value, a continuous distance from the
    target (below 0 if the load is too small), and the x of the first load here with this value,
    farther from the target, where a less accurate solution tells the value."""

    x: float
    value: float
    distance: float
    plateau: float


def share_of_way(a: Bound, b: Bound, c: Bound | None) -> float:
    """Return where `distance` is 0, as a share of the way from a to b; 0.5 if that is not known.

    a is the newest bound, b the opposite one, c the one that a has replaced. A secant at first,
    then inverse quadratic interpolation where it can be trusted (Chandrupatla, Adv. Eng. Softw. 28
    (1997) 145, doi:10.1016/S0965-9978(96)00051-8).
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
    """The root-finder for a quantity y that rises or falls with p0.

    x = log(p0 - alone), stretched such that it goes to infinity at `closes_at` (the hardness).
    tolerance: largest relative miss; error_counts: whether the error of the solution counts, too.
    """

    usual: ClassVar[float] = 1.0  # slope of f over x before any has been measured
    is_sought = True
    in_steps: ClassVar[bool] = False  # whether y goes in steps: a closed bracket is never left

    def __init__(
        self,
        value: float,
        tolerance: float,
        error_counts: bool,
        working: WorkingSurface,
        history: Sequence[dict[str, float]] = (),
    ):
        self.value = value
        self.tolerance = tolerance
        self.error_counts = error_counts
        self.finest = self.heights = working.heights
        self.closes_at = working.hardness or inf
        self.slope = self.usual
        self.corrections = 0
        self._clear()
        self._go(self._first(working.surface, history))

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

    def _first(self, surface: Surface, history: Sequence[dict[str, float]]) -> float:
        """Return x to begin with: extrapolated from loads that were solved before, or a guess."""
        for solved in history:
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

    quantity: ClassVar[str]  # its name in a history

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

    def measure(self, working: WorkingSurface) -> None:
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
        """Return the next x, or None to stay.

        y is the value at the present x, within a relative error; a prediction within `allowed` is
        not followed.
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
        """Return whether x is strictly between the bounds that exist."""
        above = self.low is None or x > self.low.x
        return above and (self.high is None or x < self.high.x)

    def bound(self, y: float, distance: float) -> None:
        """Make the present x a bound; one on the other side that contradicts it is dropped."""
        is_low = self.straight(y) < self.straight(self.aim)
        side, other = (self.low, self.high) if is_low else (self.high, self.low)
        if side is None or side.x != self.x:
            self.replaced = side
        if other is not None and (other.x <= self.x if is_low else other.x >= self.x):
            other = None
        is_same = side is not None and side.value == y
        new = Bound(self.x, y, distance, side.plateau if side and is_same else self.x)
        self.low, self.high = (new, other) if is_low else (other, new)
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
        """Return the smallest difference of x that counts."""
        return 0.0

    def end_of_plateau(self) -> float | None:
        """Return x at the end of a plateau; None if the last two bounds are not on one.

        On a plateau the same points touch, and the distance is linear in the load.
        """
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
        return self._continue(solver, self.propose(y, error, certified=True))


class Gap(Root):
    """A mean gap, in lengths over the unit of slopes."""

    quantity = "gap_mean"
    usual = 0.4

    def guess(self, surface: Surface) -> float:
        """By the gap of self-affine walls, or of a single point that carries the load."""
        alone = (self.heights.top - self.value) / (surface.grid.a * self.heights.points)
        return max(-1 - 2 * self.value * surface.slope / surface.h_rms, log(alone))

    def straight(self, y: float) -> float:
        """log(log(top/y)), as the mean gap decreases like top exp(-c p0^s)."""
        if y <= 0:
            return inf
        return log(log(self.heights.top / y)) if y < self.heights.top else -inf

    def predicted(self, solver: Solver, progress: Progress) -> Value | None:
        assert progress.estimate is not None
        error = progress.estimate.gap
        if progress.contact == solver.N:
            error = max(error, progress.estimate.pressure)
        return (progress.predicted[1] * solver.grid.a, error) if progress.predicted else None

    def within(self, solver: Solver, progress: Progress, room: float) -> bool:
        estimate = progress.estimate
        if estimate is None:
            return True
        return estimate.gap < room or estimate.attainable[0] >= self.tolerance

    def certified(self, solver: Solver, certificate: Certificate) -> Value:
        """An error that rounding keeps above the tolerance does not count: nothing can help."""
        is_limited = certificate.attainable[0] >= self.tolerance
        error = 0.0 if is_limited else certificate.errors[1]
        return certificate.gap_mean * solver.grid.a, error


class Opening(Gap):
    """A mean gap next to full contact, a power of (closes_at - p0)/p0; starts from a gap of 0.

    Where a few points are open this takes half the FFT pairs that `Gap` takes. opens: distance of
    p0 from the load that closes the gap (`begin_below`) at which one open point makes this gap.
    """

    usual = 1.5
    from_full_contact = True

    def __init__(
        self,
        value: float,
        tolerance: float,
        error_counts: bool,
        working: WorkingSurface,
        opens: float,
    ):
        self.opens = opens
        super().__init__(value, tolerance, error_counts, working)

    def begin_below(self, closes_at: float) -> None:
        """Set the load that closes the gap, and go to where one open point makes this gap."""
        self.closes_at = closes_at
        self._go(log(closes_at) + log(max(closes_at / self.opens - 1, 1.0)))

    def straight(self, y: float) -> float:
        """log(top/y), linear in log(p0/(closes_at - p0))."""
        return log(self.heights.top / y) if y > 0 else inf


class Approach(Root):
    """An approach of the bodies, in lengths over the unit of slopes."""

    quantity = "approach"
    usual = 0.8

    def guess(self, surface: Surface) -> float:
        """By the approach of a flat punch as large as the surface."""
        return log(self.value / max(surface.sizes))

    def straight(self, y: float) -> float:
        """log(y), as the approach is a power of the load."""
        return log(y) if y > 0 else -inf

    def predicted(self, solver: Solver, progress: Progress) -> Value | None:
        """Of the present displacement, not of the converged one."""
        grid = solver.grid
        share = grid.N / grid.cell_points
        (total_gap,) = grid.comm.sum([solver.g.sum(dtype=float)])
        uniform = solver.p_cell / solver.elastic.multipliers.uniform
        y = (uniform - total_gap / grid.cell_points) * grid.a
        y += self.heights.top * share - self.heights.lowest * (1 - share)
        assert progress.estimate is not None
        return y, self._error(y, progress.gap_mean * grid.a, *progress.estimate[:2])

    def certified(self, solver: Solver, certificate: Certificate) -> Value:
        a = solver.grid.a
        y = certificate.approach * a
        return y, self._error(y, certificate.gap_mean * a, *certificate.errors[1:])

    def _error(self, y: float, gap: float, gap_error: float, pressure_error: float) -> float:
        """Return the relative error of y by those of the mean gap and of the pressure field."""
        return gap_error * gap / y + FIELD * pressure_error if y > 0 else inf


class Area(Root):
    """A relative contact area: a number of points, which may jump over the target.

    What is continuous in the load is the change of pressure with which the right number of points
    would touch (`changes`). The area jumps if all points that touch at one bound only need the same
    change, except for rounding errors. Then the nearer bound is the solution, and `note` says so.
    """

    quantity = "a_r"
    in_steps = True

    def __init__(
        self,
        value: float,
        tolerance: float,
        error_counts: bool,
        working: WorkingSurface,
        history: Sequence[dict[str, float]] = (),
    ):
        surface = working.surface
        # of the map, for one point of the grid: more than 1 if heights vary along one axis only
        self.map_points = prod(surface.n) // prod(surface.grid.nominal)
        super().__init__(value, tolerance, error_counts, working, history)

    def _clear(self) -> None:
        super()._clear()
        self.jumps = False
        self.undecided = 0.0  # factor by which the pressure must improve to decide on a jump
        self.rounding = 0.0  # largest difference of two pressures that may be rounding

    @property
    def half_area(self) -> float:
        return self.value / 2

    @property
    def alone(self) -> float:
        """The load up to which the highest point certainly carries it alone."""
        return self.heights.alone

    @property
    def needs_double(self) -> bool:  # type: ignore[override]
        """Whether rounding hides which points are highest, or what a jump is."""
        finest = self.finest
        return self.jumps or finest.indistinct > max(self.value * finest.points, finest.highest)

    def guess(self, surface: Surface) -> float:
        """An elastic area is about 2 p0; with a hardness f(y) is about x."""
        return log(self.value / 2) if self.closes_at == inf else self.straight(self.value)

    @property
    def aim(self) -> float:
        """The area on this grid at the load that gives the value on the finest one.

        On a coarse grid, whose slopes are smaller, it follows from Persson's theory. The highest
        points touch at any load.
        """
        aim = self.value
        finer = self.finest.steepness / (self.heights.steepness or inf)
        if finer > 1 > aim:
            aim = erf(NormalDist().inv_cdf((1 + aim) / 2) * finer / sqrt(2))
        return max(aim, self.heights.highest / self.heights.points)

    def miss(self, y: float) -> float:
        """0 up to one point of the map."""
        miss = super().miss(y)
        return miss if miss * self.aim * self.heights.points * self.map_points > POINT else 0.0

    def straight(self, y: float) -> float:
        """x of the load at which Persson's theory, erf(c p0), has this area.

        With a hardness the area p0/hardness of a yielding contact counts, too. y is at most 1 less
        a quarter of a point.
        """
        y = min(y, 1 - 0.25 / self.heights.points)
        if y <= 0:
            return -inf
        elastic = NormalDist().inv_cdf((1 + y) / 2)
        if self.closes_at == inf:
            return log(elastic)
        return -log(hypot(2 / elastic, 1 / (y * self.closes_at)) - 1 / self.closes_at)

    def predicted(self, solver: Solver, progress: Progress) -> Value | None:
        """The error of the pressure field stands for that of the area."""
        if progress.predicted is None or progress.estimate is None:
            return None
        return round(progress.predicted[0]) / solver.N, progress.estimate.pressure

    def may_be_met(self, solver: Solver, progress: Progress, accuracy: float) -> bool:
        """A step is certainly missed if the error of the area is below the miss."""
        missed = self._predicted_miss(solver, progress)
        room = accuracy - missed if missed < accuracy else missed
        return area_may_be_met(solver, progress, room)

    def certified(self, solver: Solver, certificate: Certificate) -> Value:
        return certificate.contact / solver.N, certificate.errors[0]

    def changes(self, solver: Solver, *ranks: int) -> list[float]:
        """Return the changes of pressure with which these numbers of points touch.

        A point in contact opens if its pressure p is taken away, an open one closes if its gap g
        over the compliance of the shortest wave is added.
        """
        real = solver.problem.dtype.type
        stiffness = real(solver.problem.body.scale(solver.grid))
        points = solver.grid.inside[1]

        def change(i0: int, i1: int) -> np.ndarray:
            g = solver.g[i0:i1, :points]
            return np.where(g > 0, g * stiffness, -solver.p[i0:i1, :points])

        return [float(nth_smallest(solver.grid, change, rank)) for rank in ranks]

    def distance(self, solver: Solver, y: float) -> float:
        """By the mean of the changes that the fewest and one too many points need."""
        points = self.aim * self.heights.points
        allowed = max(self.tolerance * points, POINT / self.map_points)
        fewest = max(ceil(points - allowed), 1)
        too_many = min(max(floor(points + allowed) + 1, fewest), solver.N)
        return -0.5 * sum(self.changes(solver, fewest, too_many))

    def _resolution(self) -> float:
        return self.rounding / self.p0

    @property
    def _nearer(self) -> Bound:
        """The bound whose area is nearer to the aim; both must exist."""
        assert self.low is not None
        assert self.high is not None
        return min((self.low, self.high), key=lambda bound: abs(bound.value - self.aim))

    @property
    def _is_on_nearer_side(self) -> bool:
        return self.x in (self._nearer.x, self._nearer.plateau)

    def judge(self, solver: Solver, certificate: Certificate) -> float:
        if self.jumps and self._is_on_nearer_side:
            y, _ = self.certified(solver, certificate)
            nearer = abs(self._nearer.value - self.aim) + POINT / self.heights.points
            if abs(y - self.aim) <= nearer:
                return 0.0
            self._clear()  # this side has turned out to have another area
        if self.jumps:
            return inf
        left = super().judge(solver, certificate)
        if self.low is not None and self.high is not None:
            self.undecided = self._look_for_jump(solver, certificate)
            left = max(left, self.undecided)
        if self.jumps:
            return 0.0 if self._is_on_nearer_side else inf
        if left < 1:
            self.note = self._note_on_steps()
        return left

    def _look_for_jump(self, solver: Solver, certificate: Certificate) -> float:
        """Set `jumps` and `note` if the points between the bounds all change sides at one load.

        Returns the factor by which the pressure must become more accurate to decide this; 0 if it
        is decided, or if iterations cannot improve the pressure.
        """
        assert self.low is not None
        assert self.high is not None
        if self.x not in (self.low.x, self.high.x):
            return 0.0
        eps = float(np.finfo(np.float64).eps)
        self.rounding = ROUNDING * max(solver.problem_now.rounding, eps * solver.p0)
        apart = self.p0_of(self.high.x) - self.p0_of(self.low.x)
        if apart > self.rounding:
            ends = round(self.low.value * solver.N) + 1, round(self.high.value * solver.N)
            first, last = self.changes(solver, *ends)
            apart = last - first
        if apart > self.rounding:
            estimate = solver.progress().estimate
            if estimate is None or certificate.attainable[1]:
                return 0.0
            error = sqrt(estimate.squares / max(certificate.contact, 1))
            return min((error / apart) ** 2, error / self.rounding) if apart < error else 0.0
        self.jumps = True
        ends_of_jump = f"from {self.low.value:.4g} to {self.high.value:.4g}"
        self.note = f"a_r jumps {ends_of_jump}: the nearer is taken"
        if solver.problem.dtype != np.float64:
            self.note = f"single precision cannot tell whether a_r jumps {ends_of_jump}"
        return 0.0

    def _note_on_steps(self) -> str | None:
        """Return the note on a target that is met where one point is a large step."""
        points = self.value * self.heights.points * self.map_points
        allowed = max(self.tolerance * self.value, POINT / self.heights.points)
        if self.aim - self.value > allowed:
            return f"a_r jumps from 0 to {self.aim:.4g}: the least at any load"
        if points < 2:
            return f"a_r asks for {points:.2g} points: areas go in steps of one"
        return None

    def correct(self, solver: Solver, certificate: Certificate, solved: bool) -> bool:
        """Nothing as long as it is not certain that the area is missed, nor whether it jumps."""
        if self.jumps:
            x = self._nearer.plateau
            return self._continue(solver, None if x == self.x else x)
        y, error = self.certified(solver, certificate)
        if not self.miss(y) > error or self.undecided > 1:
            return False
        return super().correct(solver, certificate, solved)


def opening_load(gap_mean: float, working: WorkingSurface) -> float:
    """Return how far below full contact a load is at which one open point alone makes a mean gap.

    gap_mean: in the unit of the heights; the load is in the program's unit.
    """
    grid = working.surface.grid
    gap_of_point = gap_mean / working.surface.height_unit * grid.N
    return gap_of_point * float(working.model.body.near(grid)[0])


ROOTS: dict[str, type[Root]] = {root.quantity: root for root in (Area, Gap, Approach)}
