"""The search for a mean pressure, in the course of the iterations that solve for the contact.

What is asked for is monotone in the mean pressure, and a solver goes on at another one without a transform. The solver's outlook tells
what its solution would come to, ever more closely; every iteration is a reading of the curve (line.py), whose noise follows from the
estimated error, and the pressure goes where the curve has the target. Far from convergence such a correction costs no iteration, and
near it there is little left to correct. So it is on every grid of a nested start, too, and by how much the pressure changes from grid
to grid helps the next load.

The area of a grid is a number of points. It is met to the accuracy asked for or to one point; where it jumps by more, as in ordered
walls whose asperities touch all at once (staircase.py), the nearer side of the jump is taken, and `note` says so.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import exp, hypot, inf, isfinite, log
from statistics import NormalDist
from typing import TYPE_CHECKING, Any

import numpy as np

from .bracket import Bracket
from .line import Line
from .offsets import Offsets
from .staircase import Jump, Staircase
from .wall import Wall

if TYPE_CHECKING:
    from ..parallel.comm import Comm
    from ..solvers.base import Progress, Solver
    from .certificate import Certificate

NOISE = {"gap_mean": 0.12, "a_r": 0.1, "approach": 0.2}  # standard deviation of the outlook, over the estimated error of the quantity
CHANGE = {"gap_mean": 0.15, "a_r": 0.3, "approach": 0.1}  # beside it, of what it changed by in an iteration, if not with the load
PRESENT = 3.0  # times as much: of what is there already
FIELD = 0.1  # of the error of the pressure field, beside that of the mean gap: the error of the approach
VAGUE = 0.7  # error of the pressure field, or of the quantity, of what is not read
SHARE = 0.8  # of the tolerance: what is expected to be missed by less is left
WORTH = {"gap_mean": 0.1, "a_r": 0.05, "approach": 0.1}  # the same of the estimated error
BEYOND = 0.1  # noise of a quantity that is as small or large as can be
ROUNDING = 1e-13  # of straightened quantities
ENOUGH = 0.5  # of what may be missed: so near is near enough
SETTLED = 0.3  # of the tolerance: with such an error the points that touch are those that will
STEP, RANGE = log(2.0), (log(1e-99), log(1e99))  # the longest in log p0, and where that is
COARSE, FEW = 0.02, 8  # log p0, and its standard deviation, with which a coarser grid is left; corrections there, at most
GRID = 0.1  # the same, which that adds on the next grid
TRIALS, MOST = 5, 100  # corrections on a grid: from then on only by what is known for sure, between bounds, and at most
SURE = 3.0  # times the estimated error: what is missed by more is surely on the wrong side of the target
SHARP = 1e-6  # times the tolerance: no curve rises within such an interval of log p0
STEEP, STEEPER, NARROW = 2.0, 4.0, 1e-3  # times the usual slope of an area: it may jump; it jumps, within the tolerance, or this
SOLVED = 0.01  # error with which a bound is one: where much touches all at once, estimates of what changes do not know of it
SEEN, LARGE = 0.03, 3.0  # error of the pressure field at which a jump is seen; times what may be missed, a large one
SLOPES = {"gap_mean": (0.2, 5.0), "a_r": (0.4, 2.5), "approach": (0.2, 5.0)}  # that are believed: of an area, without jumps
SAME = 0.1  # of a jump: how near its side is to what was read
POINT = 1.001  # by which the area may be missed


@dataclass
class Search:
    """The state of a search: plain numbers, which make a checkpoint.

    quantity: "gap_mean", "a_r" or "approach"; target: an area, or a length over the unit of slopes; tolerance: relative; x: log p0;
    slope: of the straightened curve, before anything was read; doubt: standard deviation of the x that the target takes; wall: of
    this grid; offsets: of the x that takes the target, from grid to grid; grids: how many so far; line: the straightened curve
    about x; last: x and what was read there; corrections: on this grid; looked: last iteration looked at; missed: the target, by
    how much; side, jump: where the area jumps, the side that is taken, and by how much.
    """

    quantity: str
    target: float
    tolerance: float
    x: float
    slope: float
    doubt: float
    wall: Wall
    offsets: Offsets
    grids: int = 0
    line: Line = field(default_factory=lambda: Line(0.0, 1.0, (0.0, 0.0, 0.0)))
    bracket: Bracket = field(default_factory=Bracket)
    last: tuple[float, float] | None = None
    corrections: int = 0
    looked: int = -1
    missed: float = inf
    side: float = 0.0
    jump: float = 0.0
    note: str | None = None

    @classmethod
    def restored(cls, numbers: dict[str, Any]) -> Search:
        """From the numbers of a checkpoint."""
        wall, offsets = Wall(*numbers["wall"]), numbers["offsets"]
        parts = {"wall": wall, "offsets": Offsets(**offsets | {"finest": Wall(*offsets["finest"])}), "line": Line(**numbers["line"]),
                 "bracket": Bracket(**numbers["bracket"])}
        return cls(**numbers | parts)

    @property
    def p0(self) -> float:
        """The mean pressure, in the program's units."""
        return exp(self.x)

    @property
    def aim(self) -> float:
        """The target, or the least area that this grid has at any load."""
        return max(self.target, self.wall.highest / self.wall.points) if self.quantity == "a_r" else self.target

    @property
    def _too_small(self) -> bool:
        """Whether no load of this grid has so small an area: the least is taken, at any load that has no more."""
        return self.aim > self.target * (1 + self.least_miss)

    # -- from grid to grid -----------------------------------------------------------------------------------------------------

    def on_coarsest_grid(self) -> None:
        """A start on coarser grids begins, or one without any."""
        self.grids = 0
        self.offsets.begin()

    def on_next_grid(self, wall: Wall) -> float:
        """Go on on the next finer grid. Returns p0 to begin with.

        All grids have about the load of the finest one, where a coarser grid has another area or gap: so the contact is that of the
        load to begin with.
        """
        if self.grids:
            self.doubt, self.slope = hypot(GRID, self.line.doubt(self._way)), self.line.slope
            self.offsets.ends.append(self.x + self._way - self.offsets.ahead)
        offset = self.offsets.next(self.quantity, self.wall, wall)
        if self.grids:
            self.x = self.offsets.ends[-1] + offset + self.offsets.ahead
        self.grids, self.wall = self.grids + 1, wall
        self.bracket, self.last, self.note = Bracket(), None, None
        self.corrections, self.looked = 0, -1
        self.forget()
        return self.p0

    def forget(self) -> None:
        """Nothing was read on this grid yet."""
        self.line = Line.guessed(self._wanted, self.slope, self.doubt)

    def agree(self, comm: Comm) -> None:
        """All ranks go on with what rank 0 has found."""
        vars(self).update(comm.bcast(vars(self)))

    # -- while a solver iterates -----------------------------------------------------------------------------------------------

    def near(self, solver: Solver, progress: Progress) -> bool:
        """Whether the load of a solution on a coarser grid is as near as it need be; if not, it may be changed."""
        if not isfinite(self.straight(self.aim)) or self.corrections == FEW:
            return True
        self._read(*self._outlook(solver, progress))
        if abs(self._way) < COARSE:
            return self.line.doubt(self._way) < COARSE
        self._go_to(self.x + self._way, solver)
        return False

    def adjust(self, solver: Solver, progress: Progress, known: bool) -> bool:
        """Change the load of the solver where its own numbers say that it is wrong; returns whether. known: whether the solution is as
        accurate as asked."""
        if solver.iterations == self.looked:  # before a checkpoint
            return False
        self.looked = solver.iterations
        y, error, noise = self._outlook(solver, progress)
        now = {"a_r": progress.contact / solver.N, "gap_mean": progress.gap_mean * solver.grid.a}.get(self.quantity, y)
        self.missed = self._miss(now)
        return not (known and self.missed <= self.tolerance) and self._correct(solver, y, error, noise, now)

    @property
    def may_be_met(self) -> bool:
        """Whether it is worth asking the certificate."""
        return self.note is not None or self.missed <= self.tolerance

    def met(self, solver: Solver, certificate: Certificate) -> bool:
        """Whether the certificate finds the quantity as prescribed, or on the side of a jump that was chosen."""
        y = self._of(solver, certificate)
        met = self._miss(y) <= self.tolerance
        if self.note is not None and not met and abs(y - self.side) > max(POINT / self.wall.points, SAME * self.jump):
            self.note, self.bracket = None, Bracket()  # there was no jump
        if met and self._too_small:
            self.note = f"a_r jumps from 0 to {self.aim:.4g}: the least at any load"
        return met or self.note is not None

    def correct(self, solver: Solver, certificate: Certificate, sure: bool) -> bool:
        """Change the load of the solver where the certificate says that it is wrong; returns whether. sure: whatever its errors."""
        y = self._of(solver, certificate)
        error = 0.0 if sure else PRESENT * self._error(y, certificate.gap_mean * solver.grid.a, *certificate.errors)
        return self._correct(solver, y, error, self._noise(y, error), y)

    # -- what is known ---------------------------------------------------------------------------------------------------------

    def straight(self, y: float) -> float:
        """A function of the quantity that rises about in proportion to log p0: -inf where nothing touches, inf where all does.

        For the area it is that of Persson's theory, a_r = erf(c p0); the mean gap decreases like exp(-c p0^s).
        """
        if self.quantity == "approach":
            return log(y) if y > 0 else -inf
        if self.quantity == "a_r":
            y = min(y, 1 - 0.25 / self.wall.points)
            return log(NormalDist().inv_cdf((1 + y) / 2)) if y > 0 else -inf
        return log(log(self.wall.top / y)) if 0 < y < self.wall.top else (-inf if y > 0 else inf)

    @property
    def _point(self) -> float:
        """A point over the target: that much more or less is nothing."""
        return POINT / (self.aim * self.wall.points) if self.quantity == "a_r" else 0.0

    @property
    def least_miss(self) -> float:
        """Relative: what is missed by so much is met."""
        return max(self.tolerance, self._point)

    def _miss(self, y: float) -> float:
        """Relative."""
        miss = max(y / self.aim - 1, 0.0) if self._too_small else abs(y / self.aim - 1)
        return miss if miss > self._point else 0.0

    def _outlook(self, solver: Solver, progress: Progress) -> tuple[float, float, float]:
        """The quantity by the numbers of the solver, its estimated relative error, inf where it is not known, and its noise."""
        outlook, grid = progress.outlook, solver.grid
        if outlook is None or progress.estimates is None or not (progress.finite and progress.estimates[1] < VAGUE):
            return self.aim, inf, inf
        gap = outlook.gap_mean * grid.a
        y = outlook.contact / solver.N if self.quantity == "a_r" else gap
        if self.quantity == "approach":
            rise, share = grid.comm.sum([solver.g.sum(dtype=float)])[0] / grid.cell_points + outlook.rise, grid.N / grid.cell_points
            y = (solver.p_cell / solver.elastic.multipliers.uniform - rise) * grid.a
            y += self.wall.top * share - self.wall.lowest * (1 - share)
        gap_error, pressure_error = progress.estimates
        gap_error = max(gap_error, pressure_error) if progress.contact == solver.N else gap_error  # nothing is open yet
        error = self._error(y, gap, pressure_error, gap_error, pressure_error)
        return y, error, outlook.doubt / outlook.contact if self.quantity == "a_r" else self._noise(y, error)

    def _noise(self, y: float, error: float) -> float:
        """The standard deviation of a reading with that error, relative."""
        settled = self.quantity != "a_r" or error < SETTLED * self.least_miss
        return NOISE[self.quantity] * error + (0.0 if settled else 0.5 / max(y * self.wall.points, 0.5))

    def _of(self, solver: Solver, certificate: Certificate) -> float:
        """The quantity, as the certificate finds it."""
        if self.quantity == "a_r":
            return certificate.contact / solver.N
        return (certificate.approach if self.quantity == "approach" else certificate.gap_mean) * solver.grid.a

    def _error(self, y: float, gap: float, area_error: float, gap_error: float, pressure_error: float) -> float:
        """Relative, of the quantity."""
        if self.quantity == "approach":
            return gap_error * gap / y + FIELD * pressure_error if y > 0 else inf
        return area_error if self.quantity == "a_r" else gap_error

    # -- corrections -----------------------------------------------------------------------------------------------------------

    @property
    def _wanted(self) -> float:
        """What the straightened quantity is to be on this grid, at about the finest grid's load."""
        return self.straight(self.aim) + self.slope * self.offsets.ahead

    @property
    def _way(self) -> float:
        """By how much x is to change: not at all where this grid cannot have the target."""
        wanted = self.straight(self.aim)
        return min(max(self.line.way_to(wanted) + self.offsets.ahead, -STEP), STEP) if isfinite(wanted) else 0.0

    def _read(self, y: float, error: float, noise: float) -> None:
        """Learn that the quantity is about y at x, with that relative error; noise: its standard deviation, relative."""
        if not error < VAGUE:
            return
        f, wanted, farthest = self.straight(y), self._wanted, 2 * STEP
        noise = abs(f - self.straight(y / (1 + noise))) if isfinite(f) else BEYOND
        f = min(max(f, wanted - farthest), wanted + farthest)
        if self.last is not None:
            noise = hypot(noise, CHANGE[self.quantity] * (f - self.last[1] - self.line.slope * (self.x - self.last[0])))
        self.last = (self.x, f)
        self.line.read(f, min(max(noise, ROUNDING), farthest), SLOPES[self.quantity])

    def _go_to(self, x: float, solver: Solver) -> bool:
        """Change the load of the solver."""
        x = min(max(x, RANGE[0]), RANGE[1])
        self.line.move(x - self.x)
        self.x, self.corrections = x, self.corrections + 1
        solver.correct_load(self.p0)
        return True

    def _correct(self, solver: Solver, y: float, error: float, noise: float, now: float) -> bool:
        """y: the quantity as it will be; now: as it is."""
        self._read(y, error, noise)
        if self.corrections == MOST or not isfinite(error):
            return False
        missed = min(self._miss(y), self._miss(now)) if (y > self.aim) == (now > self.aim) else 0.0  # what changes may change sides
        if self._too_small:
            return missed > self.tolerance and self._go_to(self.x - STEP, solver)
        sure = error < SOLVED and missed > SURE * error
        stairs, wanted = None, (self.aim - now) * self.wall.points
        if self.quantity == "a_r" and error < SEEN and self._miss(now) > self.tolerance and not solver.closing:
            stairs = Staircase.of(solver, round(now * self.wall.points), wanted, self._usual_rate(now))
            jump = stairs and self._large(stairs.jump(abs(wanted), error), abs(wanted))
            if jump:
                if sure:
                    self._enclose(now, error)
                if self._enclosed:
                    return self._jump(solver)
                return self._go_beside(jump, now, solver, sure)
            self.note = None
        if self.note is not None:
            return False
        settled = error < SETTLED * self.least_miss
        if not settled and self.corrections <= TRIALS:
            level, least = self.straight(self.aim), hypot(SHARE * self.least_miss, WORTH[self.quantity] * error)
            due = abs(level - self.line.level) > abs(level - self.straight(self.aim / (1 + least)))
            return due and self._go_to(self.x + self._way, solver)
        if not (missed > self.tolerance if settled else sure):
            return False
        way = self._way_back(now, stairs)
        return self._go_between(solver, now, error, way) if sure else self._go_to(self.x + way, solver)

    def _way_back(self, y: float, stairs: Staircase | None) -> float:
        """From where the quantity is y for sure to where it is near enough: what is changed by less is solved again sooner."""
        wanted, allowed = (self.aim - y) * self.wall.points, self.least_miss * self.aim * self.wall.points
        if stairs:
            return float(np.copysign(stairs.way_between(abs(wanted) - allowed, abs(wanted) + allowed), wanted))
        return self.line.way_to(self.straight(self.aim * (1 + np.copysign(ENOUGH * self.least_miss, -wanted))))

    def _usual_rate(self, y: float) -> float:
        """Points per log p0 that touch, beside jumps."""
        step = 0.25 / self.wall.points
        y = min(max(y, 4 * step), 1 - 4 * step)
        steepness = 2 * step / (self.straight(y * (1 + step)) - self.straight(y * (1 - step)))
        return self.line.slope * steepness * y * self.wall.points

    def _large(self, jump: Jump | None, wanted: float) -> Jump | None:
        """A jump over the target by more than may be missed."""
        allowed = self.least_miss * self.aim * self.wall.points
        if jump is None or min(abs(wanted - jump.before), abs(jump.after - wanted)) <= allowed:
            return None
        return jump if jump.after - jump.before > LARGE * allowed else None

    def _go_beside(self, jump: Jump, now: float, solver: Solver, sure: bool) -> bool:
        """Stay on this side of a jump or go to the other, whichever is nearer to the target."""
        wanted, points = (self.aim - now) * self.wall.points, self.wall.points
        sign = 1 if wanted > 0 else -1
        alike = SHARE * self.least_miss * self.aim * points
        stay = abs(wanted) - jump.before <= jump.after - abs(wanted) + alike
        self.note = None
        if stay and not jump.before:
            low, high = sorted((now, now + sign * jump.after / points))
            self.side, self.jump = now, high - low
            self.note = f"a_r jumps from {low:.4g} to {high:.4g}: the nearer to what was asked for"
            return False
        bound = self.bracket.high if sign > 0 else self.bracket.low
        x = self.x + sign * min(jump.to_before if stay else jump.to_after, STEP)
        if bound and sign * (x - bound[0]) >= 0 and not sure:  # it is not before there
            return False
        return self._go_to(self.bracket.within(x), solver)

    def _go_between(self, solver: Solver, y: float, error: float, way: float) -> bool:
        """A correction by what is known for sure. way: to the target, by what seems so; where nothing changes it is doubled."""
        way = float(np.copysign(max(abs(way), 2 * self._enclose(y, error)), way))
        if self._enclosed:
            return self._jump(solver)
        x = self.x + min(max(way, -STEP), STEP)
        steep = self._rise() > STEEP
        return self._go_to(self.bracket.within(inf if steep else x), solver)

    def _enclose(self, y: float, error: float) -> float:
        """x is surely too small or too large. Returns how far it is from the last such x, 0 if y has changed since."""
        here, large = (self.x, y, error), self.straight(y) > self.straight(self.aim)
        stands = self.bracket.stands(here, large, 0.5 / self.wall.points) if self.quantity == "a_r" else 0.0
        self.bracket.add(here, large, SHARP * self.tolerance)
        return stands

    def _rise(self) -> float:
        """The slope that an area has between the bounds, at least; 0 where it may not rise."""
        low, high = self.bracket.low, self.bracket.high
        if self.quantity != "a_r" or low is None or high is None or (high[1] - low[1]) * self.wall.points < 2 * POINT:
            return 0.0
        return (self.straight(high[1] / (1 + high[2])) - self.straight(low[1] * (1 + low[2]))) / self.bracket.width

    @property
    def _enclosed(self) -> bool:
        """Whether there is nothing but a jump between the bounds."""
        return self.bracket.width <= max(NARROW, self.tolerance) and self._rise() > STEEPER

    def _jump(self, solver: Solver) -> bool:
        """Take the nearer side of a jump."""
        low, high = self.bracket.low, self.bracket.high
        assert low is not None
        assert high is not None
        x, self.side, _ = min(low, high, key=lambda bound: abs(bound[1] - self.aim))
        self.jump = high[1] - low[1]
        self.note = f"a_r jumps from {low[1]:.4g} to {high[1]:.4g}: the nearer to what was asked for"
        return x != self.x and self._go_to(x, solver)
