"""A prescribed contact area: a number of points, which may jump past the target.

What is continuous is the change of pressure with which the right number of points would touch. See
"Prescribed areas, gaps and approaches" in docs/method.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, erf, floor, hypot, inf, isfinite, log, prod, sqrt
from statistics import NormalDist
from typing import TYPE_CHECKING

import numpy as np

from ..operators.selection import nth_smallest
from .root import CORRECTIONS, STEP, TRIALS, Bound, Root, Value
from .target import DISTINCT, area_may_be_met

if TYPE_CHECKING:
    from ..certificate.certificate import Certificate
    from ..certificate.error_estimates import Estimate
    from ..solvers.base import Progress, Solver
    from ..surface import Surface
    from .working_surface import WorkingSurface

POINT = 1 + 1e-9  # points by which an area may always be missed
# Two areas at one load are no jump if the points between need changes of pressure that differ by
# more than so many times its rms error: one of them was wrong. Chosen; 68 where that has happened.
CONTRADICTS = 12.0
# At a load where errors of the heights leave points undecided, the next one decides them: there
# they need a change of pressure of more than so many times its rms error (FARTHEST in
# misclassified.py is 12). Chosen.
DECIDES = 15.0


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
        self.decisions = 0  # changes of x that decide points which change at one load
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
        """A step is certainly missed if the error of the area is below the miss. An error that is
        limited has to be seen: only another load can reduce it.
        """
        if progress.estimate is not None and self._is_limited(solver, progress.estimate):
            return True
        missed = self._predicted_miss(solver, progress)
        room = accuracy - missed if missed < accuracy else missed
        return area_may_be_met(solver, progress, room)

    def certified(self, solver: Solver, certificate: Certificate) -> Value:
        return certificate.contact / solver.N, certificate.errors[0]

    def _is_limited(self, solver: Solver, errors: Certificate | Estimate) -> bool:
        """Return whether iterations cannot reduce the error of the pressure, in double."""
        return solver.problem.dtype == np.float64 and errors.attainable[1] > 0

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
        assert self.low is not None
        assert self.high is not None
        return self.x <= self.low.x if self._nearer is self.low else self.x >= self.high.x

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
            if not at_one_load and (error > 0 or apart > _undecided(solver, certificate)):
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

    def _decided(self, solver: Solver, certificate: Certificate) -> float | None:
        """Return x at which points that change at this load have done so, or will not: towards the
        aim, or the nearer bound if both are as near; away from a jump.
        """
        if self.decisions == TRIALS or self.corrections == CORRECTIONS:
            return None
        self.decisions += 1
        self.corrections += 1
        margin = DECIDES * self.aim * _undecided(solver, certificate)
        is_above, is_below = (
            bound is not None and abs(self.p0_of(bound.x) - self.p0) < 2 * margin
            for bound in (self.high, self.low)
        )
        if self.jumps:
            rises = self._nearer is self.high
        elif is_above and is_below:
            return self._nearer.x
        else:
            rises = is_below or (not is_above and certificate.contact < self.aim * solver.N)
        x = self.x_of(self.p0 + margin if rises else self.p0 - margin)
        return x if isfinite(x) else None

    def correct(self, solver: Solver, certificate: Certificate, solved: bool) -> bool:
        """Nothing as long as it is not certain that the area is missed, nor whether it jumps."""
        if self.jumps and not self._is_on_nearer_side:
            return self._continue(solver, self._nearer.plateau)
        y, error = self.certified(solver, certificate)
        if self._is_limited(solver, certificate) and error > max(self.miss(y), self.tolerance):
            return self._continue(solver, self._decided(solver, certificate))
        if self.jumps:
            return False
        if not self.miss(y) > error or self.undecided > 1:
            return False
        return super().correct(solver, certificate, solved)


def _undecided(solver: Solver, certificate: Certificate) -> float:
    """Return the rms error of a point's pressure by the heights: rounding, and loads before."""
    problem = solver.problem_now
    return max(problem.rounding, problem.height_error / sqrt(max(certificate.contact, 1)))
