"""The load: a mean pressure that is given, or the one that gives an area, a mean gap or an
approach, which a bracketed secant method with inexact solves finds.

All three are monotone in the mean pressure p0, and a solver goes on at another p0 without a
transform. So after every iteration, on every grid of a nested start, the load is changed where the
value that the solver predicts misses the target by more than the prediction may be wrong by. Once
the contact is solved the certified value counts: it bounds the load, and a secant, or the middle
of the bounds, leads on. What is missed and the error of the solution are together no more than the
accuracy asked for. Where bounds meet and the target stays between them the area jumps, as in
ordered walls whose asperities touch all at once: the nearer side is taken, and `note` says so.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from math import copysign, erf, exp, inf, isfinite, log, sqrt
from statistics import NormalDist
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from ..util.errors import SceneError
from ..util.quantities import like, said

if TYPE_CHECKING:
    from ..certificate.certificate import Certificate
    from ..operators.problem import Problem
    from ..parallel.comm import Comm
    from ..parallel.grid import Grid
    from ..solvers.base import Progress, Solver
    from ..surface import Surface

STEP = log(2.0)  # change of log p0 over which a slope is believed
STEEPEST = 5.0  # slope of a straightened value that is believed, and 1 over the least
DUE, TRUST = 0.3, 0.4  # shares of the tolerance and of the error: a larger predicted miss counts
TRIALS, MOST = 5, 60  # corrections by predictions on a grid, and in all
SURE = 2.0  # times its error: what is missed by more bounds the load
FIELD = 0.1  # of the error of the pressure: that of the approach, beside that of the mean gap
COARSE = 0.05

JUMP = 1e-3  # of log p0, or the tolerance: within half of it nothing changes but in jumps


@dataclass(frozen=True)
class LoadTarget:
    """What a load is to give. quantity: "gap_mean", "a_r" or "approach"; value: in the scene's
    units."""

    quantity: str
    value: float


def load_targets(
    name: str, values: Sequence[float], surface: Surface, top: float, resolution: float
) -> tuple[LoadTarget, ...]:
    """Targets from the key of a scene's [load] and its values; top: mean gap where the highest peak
    just touches; resolution: least length over it that rounding errors leave as accurate as asked.
    A gap of 0 is an area of 1. Raises SceneError for what cannot be had."""
    if name == "a_r":
        for value in values:
            if value * surface.grid.N < 0.5:
                raise SceneError(
                    f"load.a_r: found {value:g}, less than half of one of {surface.grid.N} points, "
                    f"allowed: {1 / surface.grid.N:.3g} to 1"
                )
        return tuple(LoadTarget(name, float(value)) for value in values)
    unit = surface.h_rms if name == "gap_over_h_rms" else 1.0
    largest, quantity = top / unit, "approach" if name == "approach" else "gap_mean"
    for value in values:
        allowed = None
        if quantity == "gap_mean" and not value < largest:
            allowed = f"below {like(value, largest)}, where the highest peak touches"
        elif 0 < value < resolution * largest:
            allowed = f"above {like(value, resolution * largest)}, what rounding errors leave"
        if allowed:
            raise SceneError(f"load.{name}: found {said(value)}, allowed: {allowed}")
    return tuple(
        LoadTarget(quantity, float(value) * unit) if value else LoadTarget("a_r", 1.0)
        for value in values
    )


class HeightStatistics(NamedTuple):
    """Of the heights of a grid. points; highest: those as high as the highest peak, which touch at
    any load; top: mean gap where it just touches, over the unit of slopes; lowest: gap there, which
    is not 0 on a coarse grid; steepness: rms slope between neighbours in a row."""

    points: int
    highest: int
    top: float
    lowest: float
    steepness: float

    @classmethod
    def of(cls, grid: Grid, h: np.ndarray) -> HeightStatistics:
        """h: this rank's slab, in the problem's unit. Collective."""
        lowest = grid.comm.min([float(h.min(initial=np.inf))])[0]
        squares = sum(float(np.square(row[1:] - row[:-1]).sum(dtype=float)) for row in h)
        total, squares = grid.comm.sum([h.sum(dtype=float), squares])
        top = float(total / grid.N - lowest)
        equal = h <= lowest + 64 * float(np.finfo(h.dtype).eps) * top  # but for rounding errors
        highest = int(grid.comm.sum([np.count_nonzero(equal)])[0])
        steepness = float(np.sqrt(squares / grid.N) * grid.a / grid.spacings[1])
        return cls(grid.N, highest, top * grid.a, float(lowest) * grid.a, steepness)


class GivenLoad:
    """A mean pressure p0, in the program's units, that is given: there is nothing to search for."""

    note: str | None = None  # what is to be said of the load
    from_full_contact = False  # whether the gap is closed to begin with
    closes = False  # whether it is the least load that closes the gap

    def __init__(self, p0: float):
        self._p0 = p0

    @property
    def p0(self) -> float:
        """The mean pressure, in the program's units."""
        return self._p0

    @property
    def half_area(self) -> float:
        """Of the contact, about."""
        return self.p0

    def on_grid(self, problem: Problem) -> Problem:
        """The problem of the next coarse grid, at the load to begin with. Collective."""
        return problem

    def on_finest_grid(self) -> float:
        """The load to begin with there."""
        return self.p0

    def numbers(self) -> dict[str, Any] | None:
        """What makes a checkpoint."""
        return None

    def agree(self, comm: Comm) -> None:
        """All ranks go on with what rank 0 has found."""
        vars(self).update(comm.bcast(vars(self)))

    def near(self, solver: Solver, progress: Progress) -> bool:
        """Whether the load on a coarse grid is as near as it need be; if not, it may be changed."""
        return True

    def adjust(self, solver: Solver, progress: Progress) -> bool:
        """Change the load of the solver where it predicts that that is wrong; returns whether."""
        return False

    def may_be_met(self, solver: Solver, progress: Progress, accuracy: float) -> bool:
        """Whether the certificate may find the area as accurate as asked: a look at all points."""
        return (
            solver.expected_area(progress.estimates[1]) < accuracy if progress.estimates else True
        )

    def learn(self, solver: Solver, certificate: Certificate) -> float:
        """Learn what the certificate finds; returns what is missed, and its error, over the
        tolerance: below 1 the target is met."""
        return 0.0

    def correct(self, solver: Solver, certificate: Certificate, solved: bool) -> bool:
        """Change the load of the solver where the certificate finds that it is wrong; returns
        whether. solved: whether the solution is as accurate as asked."""
        return False


class ClosingLoad(GivenLoad):
    """The least load that closes the gap, where it is known at once."""

    closes = True


@dataclass
class LoadSearch(GivenLoad):
    """The state of a search: plain numbers, which make a checkpoint. A subclass knows a quantity.

    target: an area, or a length over the unit of slopes; tolerance: relative; counts: whether the
    error of the solution counts towards it; finest, heights: statistics of the finest grid and of
    this one; closes_at: p0 that closes the gap; x: log p0, or log 1/(1/p0 - 1/closes_at); slope: of
    the straightened value over x; known: whether x is known so well that coarse grids need not
    search; low, high: (x, value) that bound the load; before: (x, straightened value) of the last
    certificate; trials: corrections on this grid by predictions; corrections: in all; looked: the
    last iteration that was looked at.
    """

    kind: ClassVar[str]
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
    known: bool = False
    low: tuple[float, float] | None = None
    high: tuple[float, float] | None = None
    before: tuple[float, float] | None = None
    trials: int = 0
    corrections: int = 0
    looked: int = -1
    note: str | None = None

    # -- the quantity: what a subclass has to tell

    def guess(self, surface: Surface) -> float:
        """A first guess of log p0."""
        return 0.0

    def straight(self, y: float) -> float:
        """A function of the value that rises about in proportion to x: -inf where nothing touches,
        inf where all does."""
        raise NotImplementedError

    def predicted(self, solver: Solver, progress: Progress) -> tuple[float, float] | None:
        """What a solution at this load is expected to give, and its relative error."""
        raise NotImplementedError

    def certified(self, solver: Solver, certificate: Certificate) -> tuple[float, float]:
        """The value and its relative error."""
        raise NotImplementedError

    @property
    def aim(self) -> float:
        """The target, or what is nearest to it on this grid."""
        return self.target

    def miss(self, y: float) -> float:
        """Relative."""
        return abs(y / self.aim - 1)

    @property
    def least(self) -> str | None:
        """What is said where the target is missed because no load gives less."""
        return None

    # -- from grid to grid

    @property
    def p0(self) -> float:
        """The mean pressure, in the program's units."""
        return 1 / (exp(-self.x) + 1 / self.closes_at)

    def on_grid(self, problem: Problem) -> Problem:
        """At the load of the grid before."""
        self._begin(HeightStatistics.of(problem.grid, problem.heights))
        return replace(problem, p0=self.p0)

    def on_finest_grid(self) -> float:
        """At the load of the grid before."""
        self._begin(self.finest)
        return self.p0

    def _begin(self, heights: HeightStatistics) -> None:
        self.heights, self.trials, self.looked = heights, 0, -1
        self.low = self.high = self.before = self.note = None

    def numbers(self) -> dict[str, Any]:
        """What makes a checkpoint."""
        return {"kind": self.kind} | asdict(self)

    # -- in the course of the iterations

    def near(self, solver: Solver, progress: Progress) -> bool:
        """Whether the predicted value is as near as it is known."""
        return self.known or self.trials >= TRIALS or not self._try(solver, progress, COARSE)

    def adjust(self, solver: Solver, progress: Progress) -> bool:
        """Change the load where more than a share of the tolerance is missed."""
        if solver.iterations == self.looked or self.note or self.trials >= TRIALS:
            return False
        self.looked = solver.iterations
        return self._try(solver, progress, DUE * self.tolerance)

    def _try(self, solver: Solver, progress: Progress, least: float) -> bool:
        found = self._prediction(solver, progress)
        if found is None or self.miss(found[0]) <= max(least, TRUST * found[1]):
            return False

        x = self.x + self._way(found[0])
        if (self.low and x <= self.low[0]) or (self.high and x >= self.high[0]):
            return False
        self.trials += 1
        return self._go(x, solver)

    def _prediction(self, solver: Solver, progress: Progress) -> tuple[float, float] | None:
        """As far as it can be relied on."""
        sound = progress.finite and progress.estimates and progress.estimates[1] < STEP
        return self.predicted(solver, progress) if sound else None

    def may_be_met(self, solver: Solver, progress: Progress, accuracy: float) -> bool:
        """Whether the certificate may find the target met, or has to say by how much it is not."""
        found = None if self.note else self._prediction(solver, progress)
        if found and self.counts:
            left = self.tolerance - self.miss(found[0]) - self._own_error(solver, progress)
            if left <= 0 and self.miss(found[0]) < self.tolerance:
                return False
        return super().may_be_met(solver, progress, accuracy)

    def _own_error(self, solver: Solver, progress: Progress) -> float:
        """The relative error of the value that the certificate is expected to find."""
        raise NotImplementedError

    # -- once the contact is solved

    @property
    def _nearer(self) -> tuple[float, float]:
        """The bound whose value is nearer to the target."""
        assert self.low
        assert self.high
        return min(self.low, self.high, key=lambda bound: abs(bound[1] - self.aim))

    def learn(self, solver: Solver, certificate: Certificate) -> float:
        """Bound the load by a value that surely misses the target."""
        y, error = self.certified(solver, certificate)
        miss, here = self.miss(y), (self.x, y)
        if miss > SURE * error and not self.note:
            small = y < self.aim
            low, high = (here, self.high) if small else (self.low, here)
            if low and high and low[0] >= high[0]:  # one of them was none
                low, high = (here, None) if small else (None, here)
            self.low, self.high = low, high
            if self.steps and low and high and 2 * (high[0] - low[0]) < max(JUMP, self.tolerance):
                self.note = f"a_r jumps from {low[1]:.4g} to {high[1]:.4g}: the nearer to what was asked for"
        if self.note:
            return 0.0 if self.x == self._nearer[0] else inf
        left = (miss + (error if self.counts else 0.0)) / self.tolerance
        if left < 1:
            self.note = self.least
        return left

    def correct(self, solver: Solver, certificate: Certificate, solved: bool) -> bool:
        """To where a secant has the target, between the bounds; over a plateau at twice the way."""
        y, error = self.certified(solver, certificate)
        if self.corrections == MOST or not (solved or self.miss(y) > SURE * error):
            return False
        if self.note:
            return self._go(self._nearer[0], solver)
        longer, way = self._secant(y, error), self._way(y)
        x = self.x + copysign(max(abs(way), longer), way)
        if self.low and self.high and not self.low[0] < x < self.high[0]:
            x = 0.5 * (self.low[0] + self.high[0])
        return self._go(x, solver)

    def _secant(self, y: float, error: float) -> float:
        """Learn the slope from the last two values; returns how far it is to go at least."""
        (x, f), last = (self.x, self.straight(y)), self.before
        self.before = (x, f)
        if last is None or not abs(x - last[0]) * self.slope > SURE * error:
            return 0.0
        slope = (f - last[1]) / (x - last[0]) if f != last[1] else 0.0
        if 1 / STEEPEST < slope < STEEPEST:
            self.slope = slope
        return 2 * abs(x - last[0]) if slope <= 1 / STEEPEST else 0.0

    def _way(self, y: float) -> float:
        """By how much x is to change: not at all where this grid cannot have the target."""
        f, wanted = self.straight(y), self.straight(self.aim)
        if not isfinite(wanted):
            return 0.0
        return min(max((wanted - f) / self.slope, -STEP), STEP)

    def _go(self, x: float, solver: Solver) -> bool:
        self.x, self.corrections = x, self.corrections + 1
        solver.correct_load(self.p0)
        return True


class AreaSearch(LoadSearch):
    """For an area, which is a number of points: it is met to the tolerance or to one point."""

    kind, usual, steps = "a_r", 1.0, True

    def guess(self, surface: Surface) -> float:
        """The area is about 2 p*."""
        return log(self.half_area)

    @property
    def half_area(self) -> float:
        """Of the contact that is asked for."""
        return self.target / 2

    @property
    def aim(self) -> float:
        """The area that this grid has, by Persson's theory, where the finest has the target, or the
        least that it has at any load."""
        aim, finest, here = self.target, self.finest.steepness, self.heights.steepness
        if here < finest and 0 < here and self.target < 1:
            aim = erf(NormalDist().inv_cdf((1 + self.target) / 2) * finest / here / sqrt(2))
        return max(aim, self.heights.highest / self.heights.points)

    @property
    def least(self) -> str | None:
        """What is said where the target is missed because no load gives less."""
        few = self.aim > self.target and super().miss(self.target) > max(
            self.tolerance, self._point
        )
        return f"a_r jumps from 0 to {self.aim:.4g}: the least at any load" if few else None

    @property
    def _point(self) -> float:
        """Relative, with rounding errors."""
        return 1.001 / (self.aim * self.heights.points)

    def miss(self, y: float) -> float:
        """Relative: a point more or less is nothing."""
        miss = super().miss(y)
        return miss if miss > self._point else 0.0

    def straight(self, y: float) -> float:
        """The inverse of Persson's area, erf(c p0)."""
        y = min(y, 1 - 0.25 / self.heights.points)
        return log(NormalDist().inv_cdf((1 + y) / 2)) if y > 0 else -inf

    def predicted(self, solver: Solver, progress: Progress) -> tuple[float, float] | None:
        """As uncertain as the pressure."""
        if not (progress.predicted and progress.estimates):
            return None
        return progress.predicted[0] / solver.N, progress.estimates[1]

    def _own_error(self, solver: Solver, progress: Progress) -> float:
        return solver.expected_area(progress.estimates[1]) if progress.estimates else 0.0

    def certified(self, solver: Solver, certificate: Certificate) -> tuple[float, float]:
        """The value and its relative error."""
        return certificate.contact / solver.N, certificate.errors[0]


class GapSearch(LoadSearch):
    """For a mean gap."""

    kind, usual = "gap_mean", 0.4

    def guess(self, surface: Surface) -> float:
        """That of self-affine walls, or of one point that carries all."""
        alone = (self.heights.top - self.target) / (surface.grid.a * self.heights.points)
        return max(-1 - 2 * self.target * surface.slope / surface.h_rms, log(alone))

    def straight(self, y: float) -> float:
        """The mean gap decreases like exp(-c p0^s)."""
        return log(log(self.heights.top / y)) if 0 < y < self.heights.top else copysign(inf, -y)

    def predicted(self, solver: Solver, progress: Progress) -> tuple[float, float] | None:
        """As uncertain as the mean gap, or the pressure where nothing is open yet."""
        if not (progress.predicted and progress.estimates):
            return None
        error = max(progress.estimates) if progress.contact == solver.N else progress.estimates[0]
        return progress.predicted[1] * solver.grid.a, error

    def _own_error(self, solver: Solver, progress: Progress) -> float:
        return progress.estimates[0] if progress.estimates else 0.0

    def certified(self, solver: Solver, certificate: Certificate) -> tuple[float, float]:
        """The value and its relative error."""
        return certificate.gap_mean * solver.grid.a, certificate.errors[1]


class OpeningSearch(GapSearch):
    """For a mean gap next to full contact: it is about a power of how much less the load is."""

    kind, usual, from_full_contact = "opening", 1.5, True

    def straight(self, y: float) -> float:
        """A power of p0/(closes_at - p0)."""
        return log(self.heights.top / y) if y > 0 else inf


class ApproachSearch(LoadSearch):
    """For an approach."""

    kind, usual = "approach", 0.8

    def guess(self, surface: Surface) -> float:
        """Of a punch as large as the surface."""
        return log(self.target / max(surface.sizes))

    def straight(self, y: float) -> float:
        """A power law."""
        return log(y) if y > 0 else -inf

    def predicted(self, solver: Solver, progress: Progress) -> tuple[float, float] | None:
        """By the present displacement."""
        if not progress.estimates:
            return None
        grid, heights = solver.grid, self.heights
        share, mean = grid.N / grid.cell_points, grid.comm.sum([solver.g.sum(dtype=float)])[0]
        y = (solver.p_cell / solver.elastic.multipliers.uniform - mean / grid.cell_points) * grid.a
        y += heights.top * share - heights.lowest * (1 - share)
        gap, pressure = progress.estimates
        return y, self._error(y, progress.gap_mean * grid.a, gap, pressure)

    def _error(self, y: float, gap: float, gap_error: float, pressure_error: float) -> float:
        return gap_error * gap / y + FIELD * pressure_error if y > 0 else inf

    def _own_error(self, solver: Solver, progress: Progress) -> float:
        found = self.predicted(solver, progress)
        return found[1] if found else 0.0

    def certified(self, solver: Solver, certificate: Certificate) -> tuple[float, float]:
        """The value and its relative error."""
        y, (_, gap, pressure) = certificate.approach * solver.grid.a, certificate.errors
        return y, self._error(y, certificate.gap_mean * solver.grid.a, gap, pressure)


class FullContactSearch(LoadSearch):
    """For the least load that closes the gap. value: share of the points in contact or, where that
    is all, 1 and the lowest pressure over p0, which is to be from 0 to twice the tolerance."""

    kind, usual, from_full_contact, closes = "full contact", 1.0, True, True

    def straight(self, y: float) -> float:
        """Of a uniform pressure beside that which closes the gap."""
        return -log(2 - y) if y < 2 else inf

    @property
    def aim(self) -> float:
        """In the middle of what is allowed."""
        return 1 + self.tolerance

    def miss(self, y: float) -> float:
        """Relative; with an open point it is never small."""
        return abs(y - self.aim) if y > 1 else max(abs(y - self.aim), 2 * self.tolerance)

    def _value(self, solver: Solver, contact: float, gap: float) -> float:
        if gap > 0:
            return contact / solver.N
        rows, points = solver.grid.inside
        lowest = solver.grid.comm.min([float(solver.p[:rows, :points].min(initial=np.inf))])[0]
        return 1 + lowest / solver.p0

    def predicted(self, solver: Solver, progress: Progress) -> tuple[float, float] | None:
        """As uncertain as the pressure."""
        if not progress.estimates:
            return None
        return self._value(solver, progress.contact, progress.gap_mean), progress.estimates[1]

    def _own_error(self, solver: Solver, progress: Progress) -> float:
        return 0.0

    def certified(self, solver: Solver, certificate: Certificate) -> tuple[float, float]:
        """The value; its error moves no point."""
        return self._value(solver, certificate.contact, certificate.gap_mean), 0.0


SEARCHES: dict[str, type[LoadSearch]] = {
    search.kind: search
    for search in (AreaSearch, GapSearch, ApproachSearch, OpeningSearch, FullContactSearch)
}


def opening_search(
    target: float,
    tolerance: float,
    counts: bool,
    heights: HeightStatistics,
    closes_at: float,
    opens: float,
) -> LoadSearch:
    """The search next to full contact, from where a single point would open so far."""
    x = log(closes_at) + log(max(closes_at / opens - 1, 1.0))
    search = OpeningSearch(target, tolerance, counts, heights, heights, closes_at, x)
    search.slope = search.usual
    return search


def search_for(
    target: LoadTarget,
    surface: Surface,
    heights: HeightStatistics,
    tolerance: float,
    counts: bool,
    history: Sequence[dict[str, float]],
) -> LoadSearch:
    """The search for the load that gives a target; history: loads that were solved before, each
    with its x and what it gave."""
    kind, found = target.quantity, SEARCHES[target.quantity]
    value = target.value if kind == "a_r" else target.value / surface.slope
    search = found(value, tolerance, counts, heights, heights, slope=found.usual)
    wanted, straight = search.straight(search.aim), search.straight
    known = [(point["x"], f) for point in history if isfinite(f := straight(point[kind]))][-2:]
    if not known:
        search.x = search.guess(surface)
        return search
    (x0, f0), (x, f) = known[0], known[-1]
    slope = (f - f0) / (x - x0) if x != x0 else 0.0
    near = 1 / STEEPEST < slope < STEEPEST and abs(wanted - f) < 4 * STEP * slope
    search.slope = slope if near else found.usual
    search.x = x + (wanted - f) / search.slope
    search.known = near and abs(search.x - x) < STEP
    return search


def restored(numbers: dict[str, Any]) -> LoadSearch:
    """From the numbers of a checkpoint."""
    parts = {name: HeightStatistics(*numbers[name]) for name in ("finest", "heights")}
    own = {name: value for name, value in numbers.items() if name != "kind"}
    return SEARCHES[numbers["kind"]](**own | parts)
