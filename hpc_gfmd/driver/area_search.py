"""The search for the load that gives a contact area, which is a number of points.

The target is met to the tolerance or to one point. The number of points is not continuous in the
load. Between two loads the search uses a quantity that is: the change of pressure that would give
the contact the right number of points (side_changes.py). In ordered walls many points change sides
at the same load. The area jumps there; if it jumps over the target, the nearer side is taken and
`note` reports it. It counts as a jump if the points that are in only one of the contacts on both
sides need the same change of pressure, except for rounding errors, or if the two loads are equal.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, erf, floor, hypot, inf, isfinite, isinf, log, sqrt
from statistics import NormalDist
from typing import TYPE_CHECKING

import numpy as np

from .bracket import Bound, Bracket
from .full_contact import CLOSED
from .load_search import CALIBRATION, Errors, SecantSearch, Value
from .search import area_may_be_met
from .side_changes import SideChanges

if TYPE_CHECKING:
    from ..certificate.certificate import Certificate
    from ..operators.problem import Problem
    from ..solvers.base import Progress, Solver
    from ..surface import Surface

POINT = 1.001  # number of points of the map by which an area may always be missed
BEYOND = 0.5  # how far the load goes beyond the end of a plateau, over the way to this end


@dataclass
class AreaSearch(SecantSearch):
    """A search for the load that gives a contact area. For other attributes see `SecantSearch`.

    Attributes
    ----------
    map_points : int
        Number of points of the map that one point of the grid stands for; more than 1 if the map
        varies along one axis only.
    extrapolated : bool
        Whether the present load is the expected end of a plateau.
    jumps : bool
        Whether the area jumps over the target, as far as the precision can tell.
    undecided : float
        Factor by which the pressure must become more accurate to decide whether it jumps; 0 if that
        is decided.
    """

    usual = 1.0

    map_points: int = 1
    extrapolated: bool = False
    jumps: bool = False
    undecided: float = 0.0

    # -- the quantity

    def guess(self, surface: Surface) -> float:
        """Guess x: an elastic area is about 2 p0; with a hardness f(target) is about x.

        Neither `surface` nor the search is changed; `surface` is not used.
        """
        return log(self.half_area) if isinf(self.closes_at) else self.straight(self.target)

    @property
    def half_area(self) -> float:
        """Half of the prescribed relative contact area."""
        return self.target / 2

    @property
    def aim(self) -> float:
        """The area on this grid at the load that gives the target on the finest one.

        On a coarse grid, whose slopes are smaller, this follows from Persson's theory. It is at
        least the area of the highest points, which touch at any load.
        """
        aim = self.target
        finer = self.finest.steepness / (self.heights.steepness or inf)
        if finer > 1 > aim:
            aim = erf(NormalDist().inv_cdf((1 + aim) / 2) * finer / sqrt(2))
        return max(aim, self.heights.highest / self.heights.points)

    @property
    def allowed(self) -> float:
        """Number of points of this grid by which the aim may be missed (a fraction if the grid
        stands for a larger map)."""
        point = POINT / self.map_points
        return max(self.tolerance * self.aim * self.heights.points, point)

    def miss(self, y: float) -> float:
        """Return the relative distance of y from the aim; 0 up to one point of the map."""
        miss = super().miss(y)
        return miss if miss * self.aim * self.heights.points * self.map_points > POINT else 0.0

    def straight(self, y: float) -> float:
        """Return f(y): x at the load where Persson's theory, erf(c p0), has the relative area y.

        With a hardness the area y = p0/hardness of a yielding contact counts, too. -inf for y <= 0;
        y is limited to 1 less a quarter of a point.
        """
        y = min(y, 1 - 0.25 / self.heights.points)
        if y <= 0:
            return -inf
        elastic = NormalDist().inv_cdf((1 + y) / 2)
        if isinf(self.closes_at):
            return log(elastic)
        p0 = 1 / hypot(2 / elastic, 1 / (y * self.closes_at))
        return -log(1 / p0 - 1 / self.closes_at)

    def predicted(self, solver: Solver, progress: Progress, errors: Errors) -> Value | None:
        """Predict the relative area by `progress.predicted`; None without that.

        The error of the pressure field stands for that of the area.
        """
        return (round(progress.predicted[0]) / solver.N, errors[1]) if progress.predicted else None

    def may_be_met(self, solver: Solver, progress: Progress, accuracy: float) -> bool:
        """Return whether a certificate may find the target met, or certainly missed.

        The error of the area must be less than what the predicted miss leaves of the accuracy; if
        the miss is larger than the accuracy, less than the miss. Collective.
        """
        missed = self._predicted_miss(solver, progress)
        room = accuracy - missed if missed < accuracy else missed
        return area_may_be_met(solver, progress, room)

    def certified(self, solver: Solver, certificate: Certificate) -> Value:
        """Return the certified relative area and its error."""
        return certificate.contact / solver.N, certificate.errors[0]

    @property
    def _alone(self) -> float:
        """Mean pressure up to which the highest point certainly carries the load alone.

        It is p_1 in x = log(p0 - p_1), of the present grid, in the program's unit; 0 if several
        points are as high.
        """
        return self.heights.alone

    @property
    def needs_double(self) -> bool:
        """Whether single precision cannot distinguish the heights of the points in contact, or
        whether the area jumps: single precision cannot tell a jump from rounding errors."""
        finest = self.finest
        return self.jumps or finest.indistinct > max(self.target * finest.points, finest.highest)

    # -- between two loads

    def distance(self, solver: Solver, y: float) -> float:
        """Return how far the load is beyond the aim, as a pressure in the program's unit.

        Below 0 if the load is too small. The contact has k points once the pressure has changed by
        the k-th value of `SideChanges`. The distance is minus the mean of two of these values: for
        the smallest number of points that meets the aim, and for the smallest that is too large.
        `y` is not used; the solver is not changed. Collective.
        """
        points = self.aim * self.heights.points
        fewest = max(ceil(points - self.allowed), 1)
        too_many = min(max(floor(points + self.allowed) + 1, fewest), solver.N)
        changes = SideChanges(solver, solver.problem_now.rounding)
        return -0.5 * (changes.of_rank(fewest) + changes.of_rank(too_many))

    def begin(self, problem: Problem | None = None) -> float:
        """Begin on another grid at the present load, and return p0; forget jumps, too. Collective.

        See `SecantSearch.begin`. p0 may change with the highest points of the grid, x does not.
        """
        self.jumps = False
        self.undecided = 0.0
        return super().begin(problem)

    def adjust(self, solver: Solver, progress: Progress) -> bool:
        """Change p0 by predictions until the bracket is closed; return whether it has changed."""
        return not self.bracket.is_closed and super().adjust(solver, progress)

    def learn(self, solver: Solver, certificate: Certificate) -> float:
        """Add the load to the bracket, and decide whether the area jumps over the target.

        Sets `undecided`, `jumps` and `note`. Returns what `SecantSearch.learn` returns, or
        `undecided` if that is larger; at a jump 0 on its nearer side and infinity on the other one.
        """
        if self.jumps:
            return self._confirm(solver, certificate)
        left = super().learn(solver, certificate)
        self.undecided = self._accuracy_needed(solver, certificate)
        left = max(left, self.undecided)
        self.jumps = self._changes_at_once(solver)
        if self.jumps:
            below, above = self.bracket.bounds
            ends = f"from {below.value:.4g} to {above.value:.4g}"
            self.note = f"a_r jumps {ends}: the nearer is taken"
            if solver.problem.dtype != np.float64:
                self.note = f"single precision cannot tell whether a_r jumps {ends}"
            return self._confirm(solver, certificate)
        if left < 1:
            self.note = self._step_note()
        return left

    def _step_note(self) -> str | None:
        """Return the note on a target that is met although one point is a large step of the area;
        None if it is not."""
        points = self.target * self.heights.points * self.map_points
        allowed = max(self.tolerance * self.target, POINT / self.heights.points)
        if self.aim - self.target > allowed:
            return f"a_r jumps from 0 to {self.aim:.4g}: the least at any load"
        if points < 2:
            return f"a_r asks for {points:.2g} points: areas go in steps of one"
        return None

    def correct(self, solver: Solver, certificate: Certificate, solved: bool) -> bool:
        """Change p0: to the nearer side of a jump, between the bounds, or beyond a plateau.

        Returns whether it has changed: not if the target is not certainly missed, nor while the
        solution is too inaccurate to decide on a jump.
        """
        if self.corrections == CALIBRATION.corrections:
            return False
        if self.jumps:
            plateau = self._nearer.plateau
            return self.x != plateau and self._go(plateau, solver)
        y, error = self.certified(solver, certificate)
        surely_missed = self.miss(y) > error
        if not surely_missed or self.undecided > 1:
            return False
        if self.bracket.is_closed:
            return self._go(self._between(solver), solver)
        end = self._end_of_plateau()
        if end is None:
            return super().correct(solver, certificate, solved)
        return self._go(end + BEYOND * (end - self.x), solver)

    def _between(self, solver: Solver) -> float:
        """Return the next x between the two bounds, and set `extrapolated`.

        It is the end of a plateau, unless this was tried last time, else that of the bracket.
        """
        end = self._end_of_plateau()
        self.extrapolated = not self.extrapolated and end is not None
        if end is None or not self.extrapolated or self.bracket.excludes(end):
            return self.bracket.between(self._rounding(solver) / solver.p0)
        return end

    def _end_of_plateau(self) -> float | None:
        """Return x at the expected end of a plateau; None if the last two loads are not on one.

        On a plateau the same points touch; pressures and gaps are then linear in the load.
        """
        bracket = self.bracket
        newest = bracket.low if bracket.newest_is_low else bracket.high
        before = bracket.replaced
        if newest is None or before is None or newest.value != before.value:
            return None
        p0 = self.p0_of(newest.x)
        slope = (newest.distance - before.distance) / (p0 - self.p0_of(before.x))
        end = self.x_of(p0 - newest.distance / slope) if slope > 0 else inf
        return end if isfinite(end) else None

    def _rounding(self, solver: Solver) -> float:
        """Return the largest difference of two pressures that may be due to rounding errors."""
        of_load = float(np.finfo(np.float64).eps) * solver.p0
        return CLOSED * max(solver.problem_now.rounding, of_load)

    def _accuracy_needed(self, solver: Solver, certificate: Certificate) -> float:
        """Return the factor by which the pressure must become more accurate to decide on a jump.

        To decide is whether all points that change sides between the bounds do so at the same
        load. 0 if that is decided, without two bounds, or if iterations cannot improve the
        pressure. Collective.
        """
        estimate = solver.progress().estimate
        if estimate is None or certificate.attainable[1] or not self.bracket.is_closed:
            return 0.0
        error = sqrt(estimate.squares / max(certificate.contact, 1))
        rounding = self._rounding(solver)
        apart = self._apart(solver)
        if not rounding < apart < error:
            return 0.0
        return min((error / apart) ** 2, error / rounding)

    def _apart(self, solver: Solver) -> float:
        """Return the spread of the changes of pressure that move the points between the bounds.

        These are the points that touch at the upper bound only. Needs both bounds. Collective.
        """
        low, high = self.bracket.bounds
        changes = SideChanges(solver, solver.problem_now.rounding)
        nearest = changes.of_rank(round(low.value * solver.N) + 1)
        farthest = changes.of_rank(round(high.value * solver.N))
        return farthest - nearest

    def _changes_at_once(self, solver: Solver) -> bool:
        """Return whether all points between the bounds change sides at the same load, a jump.

        False without two bounds, and if the present load is neither. Collective.
        """
        if not self.bracket.is_closed:
            return False
        low, high = self.bracket.bounds
        if self.x not in (low.x, high.x):
            return False
        rounding = self._rounding(solver)
        if self.p0_of(high.x) - self.p0_of(low.x) <= rounding:
            return True
        return self._apart(solver) <= rounding

    @property
    def _nearer(self) -> Bound:
        """The bound whose area is closer to the aim; there must be a bound."""
        return min(self.bracket.bounds, key=lambda bound: abs(bound.value - self.aim))

    def _confirm(self, solver: Solver, certificate: Certificate) -> float:
        """Check a certificate at a jump: return 0 on its nearer side, infinity on the other one.

        If the nearer side turns out to have another area, the search begins again: the bracket,
        jump and note are cleared, and the miss over the tolerance is returned.
        """
        nearer = self._nearer
        y, _ = self.certified(solver, certificate)
        point = POINT / self.heights.points
        if self.x not in (nearer.x, nearer.plateau):
            return inf
        if abs(y - self.aim) <= abs(nearer.value - self.aim) + point:
            return 0.0
        self.note = None
        self.jumps = False
        self.bracket = Bracket()
        return super().learn(solver, certificate)
