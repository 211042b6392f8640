"""The quantities whose load the root-finder (root.py) finds: mean gap, approach, contact area.

Each is its value, predicted by the solver or certified, and a function that makes it nearly linear
in x = log p0. An area is a number of points, which may jump past the target; the change of pressure
with which the right number of points would touch is continuous. See "Prescribed areas, gaps and
approaches" in docs/method.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, erf, floor, hypot, inf, log, prod, sqrt
from statistics import NormalDist
from typing import TYPE_CHECKING

import numpy as np

from ..operators.selection import nth_smallest
from .root import STEP, Bound, Root, Value
from .target import DISTINCT, area_may_be_met

if TYPE_CHECKING:
    from ..certificate.certificate import Certificate
    from ..solvers.base import Progress, Solver
    from ..surface import Surface
    from .working_surface import WorkingSurface

POINT = 1 + 1e-9  # points by which an area may always be missed
# `opening_load` below which a gap is sought from full contact. Chosen: alike from 5 to 20; at .2
# gaps of 1e-5 h_rms take 3 times the pairs, at 1000 those of 1e-2 h_rms 1.7 times
NEARLY_CLOSED = 5.0
# Share of the error of the pressure field that counts as error of an approach. Chosen: from .025 to
# .4 no approach of 27 open walls and layers is wrong, and loads take 22.8 to 19.6 pairs.
FIELD = 0.1
# Two areas at one load are no jump if the points between need changes of pressure that differ by
# more than so many times its rms error: one of them was wrong. Chosen; 68 where that has happened.
CONTRADICTS = 12.0


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
    """A mean gap next to full contact, a power of (closes_at - p0)/p0, from a gap of 0: half the
    pairs of `Gap` where few points are open. closes_at: the load that closes the gap; opens: how
    far below that one open point makes the gap.
    """

    usual = 1.5
    from_full_contact = True

    def __init__(self, value: float, working: WorkingSurface, opens: float, closes_at: float):
        super().__init__(value, working)
        self.closes_at = closes_at
        self._go(log(closes_at) + log(max(closes_at / opens - 1, 1.0)))

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
        (total_gap,) = grid.comm.sum([solver.state.g.sum(dtype=float)])
        uniform = solver.state.p_cell / solver.elastic.multipliers.uniform
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

    What is continuous is the change of pressure with which the right number would touch
    (`changes`). The area jumps if all points that touch at one bound only need the same change, up
    to rounding: the nearer bound is then the solution, and `note` says so.
    """

    quantity = "a_r"
    in_steps = True

    def __init__(
        self, value: float, working: WorkingSurface, earlier: Sequence[dict[str, float]] = ()
    ):
        surface = working.surface
        # of the map, for one point of the grid: more than 1 if heights vary along one axis only
        self.map_points = prod(surface.n) // prod(surface.grid.nominal)
        super().__init__(value, working, earlier)

    def _clear(self) -> None:
        super()._clear()
        self.jumps = False
        self.may_jump = False  # whether single precision cannot tell whether it jumps
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
        return self.may_jump or finest.indistinct > max(self.value * finest.points, finest.highest)

    def guess(self, surface: Surface) -> float:
        """An elastic area is about 2 p0; with a hardness f(y) is about x."""
        return log(self.value / 2) if self.closes_at == inf else self.straight(self.value)

    @property
    def aim(self) -> float:
        """The area on this grid at the target's load: on coarse grids, of smaller slopes, by
        Persson's theory, with the highest points at least.
        """
        aim = self.value
        finer = self.finest.steepness / (self.heights.steepness or inf)
        if finer > 1 > aim:
            aim = erf(NormalDist().inv_cdf((1 + aim) / 2) * finer / sqrt(2))
        return max(aim, self._least)

    @property
    def _least(self) -> float:
        """The area at any load, however small."""
        return self.heights.highest / self.heights.points

    def propose(
        self, y: float, error: float, certified: bool, allowed: float = 0.0
    ) -> float | None:
        """Towards the least area, below which there is no load, in steps of twice the one before:
        the last few points hardly change the area.
        """
        x = super().propose(y, error, certified, allowed)
        if x is None or not certified or self.low is not None or self.aim > self._least:
            return x
        before = self.replaced.x - self.x if self.replaced is not None else 0.0
        return min(x, self.x - max(2 * before, STEP))

    def miss(self, y: float) -> float:
        """0 up to one point of the map, also from a value below the least area of any load."""
        points = self.heights.points * self.map_points
        beyond = max(self._least - self.value, 0.0) * points if self.aim == self._least else 0.0
        miss = super().miss(y)
        return miss if miss * self.aim * points > max(POINT - beyond, 0.0) else 0.0

    def straight(self, y: float) -> float:
        """x of the load at which Persson's theory, plus p0/hardness, has the area y."""
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
        """Return the changes of pressure with which these numbers of points touch: p opens a point,
        gap over compliance closes it.
        """
        state = solver.state
        real = solver.problem.dtype.type
        stiffness = real(solver.problem.body.scale(solver.grid))
        points = solver.grid.inside[1]

        def change(i0: int, i1: int) -> np.ndarray:
            g = state.g[i0:i1, :points]
            return np.where(g > 0, g * stiffness, -state.p[i0:i1, :points])

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
        """Set `jumps` and `note` if all points between the bounds change at one load; return how
        much more accurate the pressure must be, 0 if decided or impossible.
        """
        assert self.low is not None
        assert self.high is not None
        if self.x not in (self.low.x, self.high.x):
            return 0.0
        eps = float(np.finfo(np.float64).eps)
        self.rounding = DISTINCT * max(solver.problem_now.rounding, eps * solver.state.p0)
        at_one_load = self.p0_of(self.high.x) - self.p0_of(self.low.x) <= self.rounding
        ends = round(self.low.value * solver.N) + 1, round(self.high.value * solver.N)
        least, largest = self.changes(solver, *ends)
        apart = largest - least
        if apart > self.rounding:
            estimate = solver.progress().estimate
            error = 0.0
            if estimate is not None and not certificate.attainable[1]:
                error = sqrt(estimate.squares / max(certificate.contact, 1))
            if at_one_load and apart > CONTRADICTS * error > 0:
                self._drop_opposite()
                return 0.0
            if not at_one_load:
                return min((error / apart) ** 2, error / self.rounding) if apart < error else 0.0
        self.jumps = True
        ends_of_jump = f"from {self.low.value:.4g} to {self.high.value:.4g}"
        self.note = f"a_r jumps {ends_of_jump}: the nearer is taken"
        if solver.problem.dtype != np.float64:
            self.may_jump = True
            self.note = f"single precision cannot tell whether a_r jumps {ends_of_jump}"
        return 0.0

    def _drop_opposite(self) -> None:
        """Drop the bound that the present load contradicts: its area was not yet right."""
        assert self.low is not None
        if self.x == self.low.x:
            self.high = None
        else:
            self.low = None
        self.replaced = None

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
    """Return how far below full contact (program's unit) one open point alone makes a mean gap."""
    grid = working.surface.grid
    gap_of_point = gap_mean / working.surface.height_unit * grid.N
    return gap_of_point * float(working.model.body.near(grid)[0])


ROOTS: dict[str, type[Root]] = {root.quantity: root for root in (Area, Gap, Approach)}
