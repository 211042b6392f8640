"""The search for the load that gives a contact area, which is a number of points.

It is met to the tolerance or to one point. Between two loads the number of points is found by what
is continuous in the load: how far those points are from a change of sides that the target has, or
has not (side_changes.py). In ordered walls many points change sides at the same load. The area
jumps there, and where it jumps over the target the nearer side is taken, and `note` says so. It is
a jump where the points in which the contacts on both sides differ are alike to rounding errors, or
where the loads themselves are.
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

POINT = 1.001  # points of the map by which an area may be missed
BEYOND = 0.5  # of the way to the end of a plateau that is gone beyond it


@dataclass
class AreaSearch(SecantSearch):
    """A search for a contact area; all else that it knows: see `SecantSearch`.

    Attributes
    ----------
    map_points : int
        Points of the map that a point of the grid stands for: more than one where the map varies
        along one axis only.
    extrapolated : bool
        Whether the present load is where a plateau was expected to end.
    jumps : bool
        Whether the area jumps over the target.
    undecided : float
        By how much the pressure has to be more accurate to know that, above 1 where it has.
    """

    usual = 1.0

    map_points: int = 1
    extrapolated: bool = False
    jumps: bool = False
    undecided: float = 0.0

    # -- the quantity

    def guess(self, surface: Surface) -> float:
        """Guess by an area of about 2 p*; with a hardness `straight` is about x."""
        return log(self.half_area) if isinf(self.closes_at) else self.straight(self.target)

    @property
    def half_area(self) -> float:
        """Half of the contact area that is asked for."""
        return self.target / 2

    @property
    def aim(self) -> float:
        """The area that this grid has, by Persson's theory, where the finest has the target, or the
        least that it has at any load."""
        aim = self.target
        finer = self.finest.steepness / (self.heights.steepness or inf)
        if finer > 1 > aim:
            aim = erf(NormalDist().inv_cdf((1 + aim) / 2) * finer / sqrt(2))
        return max(aim, self.heights.highest / self.heights.points)

    @property
    def allowed(self) -> float:
        """Points of this grid by which the aim may be missed."""
        point = POINT / self.map_points
        return max(self.tolerance * self.aim * self.heights.points, point)

    def miss(self, y: float) -> float:
        """Return how far y is from the aim, relative; a point more or less is none."""
        miss = super().miss(y)
        return miss if miss * self.aim * self.heights.points * self.map_points > POINT else 0.0

    def straight(self, y: float) -> float:
        """Invert Persson's area, erf(c p0), and p0 over the hardness."""
        y = min(y, 1 - 0.25 / self.heights.points)
        if y <= 0:
            return -inf
        elastic = NormalDist().inv_cdf((1 + y) / 2)
        if isinf(self.closes_at):
            return log(elastic)
        p0 = 1 / hypot(2 / elastic, 1 / (y * self.closes_at))
        return -log(1 / p0 - 1 / self.closes_at)

    def predicted(self, solver: Solver, progress: Progress, errors: Errors) -> Value | None:
        """Predict the area by the load that the points in contact carry: as uncertain as the
        pressure."""
        return (round(progress.predicted[0]) / solver.N, errors[1]) if progress.predicted else None

    def may_be_met(self, solver: Solver, progress: Progress, accuracy: float) -> bool:
        """Return whether the certificate may find the target met, or surely missed."""
        missed = self._predicted_miss(solver, progress)
        room = accuracy - missed if missed < accuracy else missed
        return area_may_be_met(solver, progress, room)

    def certified(self, solver: Solver, certificate: Certificate) -> Value:
        """Return the area of the certificate."""
        return certificate.contact / solver.N, certificate.errors[0]

    @property
    def _alone(self) -> float:
        return self.heights.alone

    @property
    def needs_double(self) -> bool:
        """Whether the target asks for heights that single precision cannot tell apart, or what it
        found may be a jump but for its rounding errors."""
        finest = self.finest
        return self.jumps or finest.indistinct > max(self.target * finest.points, finest.highest)

    # -- between two loads

    def distance(self, solver: Solver, y: float) -> float:
        """Return the pressure by which points are beyond the state in the middle of those that meet
        the target."""
        points = self.aim * self.heights.points
        fewest = max(ceil(points - self.allowed), 1)
        too_many = min(max(floor(points + self.allowed) + 1, fewest), solver.N)
        changes = SideChanges(solver, solver.problem_now.rounding)
        return -0.5 * (changes.of_rank(fewest) + changes.of_rank(too_many))

    def begin(self, problem: Problem | None = None) -> float:
        """Begin at the load of the grid before."""
        self.jumps = False
        self.undecided = 0.0
        return super().begin(problem)

    def adjust(self, solver: Solver, progress: Progress) -> bool:
        """Follow predictions until the target lies between two loads."""
        return not self.bracket.is_closed and super().adjust(solver, progress)

    def learn(self, solver: Solver, certificate: Certificate) -> float:
        """Learn as of any value, and whether the area jumps over the target."""
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
        """Return what has to be said of a target that is met, where steps of the area are large
        beside it."""
        points = self.target * self.heights.points * self.map_points
        allowed = max(self.tolerance * self.target, POINT / self.heights.points)
        if self.aim - self.target > allowed:
            return f"a_r jumps from 0 to {self.aim:.4g}: the least at any load"
        if points < 2:
            return f"a_r asks for {points:.2g} points: areas go in steps of one"
        return None

    def correct(self, solver: Solver, certificate: Certificate, solved: bool) -> bool:
        """Go to the nearer side of a jump, or between the bounds."""
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
        """Return the next x between two bounds: the end of a plateau, where it was not just tried,
        or what the bracket says."""
        end = self._end_of_plateau()
        self.extrapolated = not self.extrapolated and end is not None
        if end is None or not self.extrapolated or self.bracket.excludes(end):
            return self.bracket.between(self._rounding(solver) / solver.p0)
        return end

    def _end_of_plateau(self) -> float | None:
        """Return x where a plateau ends, None where the last two loads are not on one.

        While the same points touch, pressures and gaps are linear in the load.
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
        """Return the difference of pressures that may be rounding errors."""
        of_load = float(np.finfo(np.float64).eps) * solver.p0
        return CLOSED * max(solver.problem_now.rounding, of_load)

    def _accuracy_needed(self, solver: Solver, certificate: Certificate) -> float:
        """Return by how much the pressure has to be more accurate to tell whether the points that
        change sides between the bounds are alike; 0 where that is known. Collective."""
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
        """Return by how much pressures differ that take the points in which the contacts at the
        bounds differ to the other side. Collective."""
        low, high = self.bracket.bounds
        changes = SideChanges(solver, solver.problem_now.rounding)
        nearest = changes.of_rank(round(low.value * solver.N) + 1)
        farthest = changes.of_rank(round(high.value * solver.N))
        return farthest - nearest

    def _changes_at_once(self, solver: Solver) -> bool:
        """Return whether the contact changes at once from one bound to the other. Collective."""
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
        return min(self.bracket.bounds, key=lambda bound: abs(bound.value - self.aim))

    def _confirm(self, solver: Solver, certificate: Certificate) -> float:
        """Return 0 at the nearer side of a jump, as it was found; where it is not, begin anew."""
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
