"""The search for a mean pressure, in the course of the iterations that solve for the contact.

What is asked for is monotone in the mean pressure, and a solver goes on at another one without a
transform. The solver's outlook tells what its solution would come to, ever more closely; every
iteration is a reading of the curve (line.py), whose noise follows from the estimated error, and the
pressure goes where the curve has the target. Far from convergence such a correction costs no
iteration, and near it there is little left to correct. So it is on every grid of a nested start,
too, and by how much the pressure changes from grid to grid helps the next load.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import exp, hypot, inf, isfinite, log
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from .bracket import Bracket
from .line import Line
from .offsets import Offsets
from .wall import Wall

if TYPE_CHECKING:
    from ..certificate.certificate import Certificate
    from ..parallel.comm import Comm
    from ..solvers.base import Outlook, Progress, Solver
    from ..surface import Surface
    from .prescribed import Prescribed

PRESENT = 3.0  # times as much noise: of what is there already
VAGUE = 0.7  # error of the pressure field, or of the quantity, of what is not read
SHARE = 0.8  # of the tolerance: what is expected to be missed by less is left
BEYOND = 0.1  # noise of a quantity that is as small or large as can be
ROUNDING = 1e-13  # of straightened quantities
ENOUGH = 0.5  # of what may be missed: so near is near enough
SETTLED = 0.3  # of the tolerance: with such an error the points that touch are those that will
STEP, RANGE = log(2.0), (log(1e-99), log(1e99))  # the longest in log p0, and where that is
COARSE, FEW = (
    0.02,
    8,
    # log p0, and its standard deviation, with which a coarser grid is left; corrections there, at
    # most
)
GRID = 0.1  # the same, which that adds on the next grid
TRIALS, MOST = (
    5,
    100,
)  # corrections on a grid: from then on only by what is known for sure, between bounds, and at most
# times the estimated error: what is missed by more is surely on the wrong side of the target
SURE = 3.0
SHARP = 1e-6  # times the tolerance: no curve rises within such an interval of log p0
# error with which a bound is one: where much touches all at once, estimates of what changes do not
# know of it
SOLVED = 0.01


@dataclass
class Search:
    """The state of a search: plain numbers, which make a checkpoint. A subclass knows what is
    searched for: a quantity.

    target: an area, or a length over the unit of slopes; tolerance: relative; x: log p0; slope: of
    the straightened curve, before anything was read; doubt: standard deviation of the x that the
    target takes; wall: of this grid; offsets: of the x that takes the target, from grid to grid;
    grids: how many so far; line: the straightened curve about x; last: x and what was read there;
    corrections: on this grid; looked: last iteration looked at; missed: the target, by how much;
    note: what is to be said of it.
    """

    quantity: ClassVar[str]  # as Prescribed has it
    kind: ClassVar[str]  # of search, in a checkpoint
    usual: ClassVar[float]  # slope, before anything is known
    slopes: ClassVar[tuple[float, float]] = (0.2, 5.0)  # that are believed
    bent: ClassVar[float]  # share of the bend of the last three loads that goes on
    trend: ClassVar[
        float
    ]  # of what a grid changed log p0 by, beside what its slopes tell: the next one
    by_steepness: ClassVar[bool] = (
        False  # whether the same takes a load in proportion to the slopes of a grid
    )
    noise: ClassVar[
        float
    ]  # standard deviation of the outlook, over the estimated error of the quantity
    change: ClassVar[
        float
    ]  # beside it, of what it changed by in an iteration, if not with the load
    worth: ClassVar[float] = (
        0.1  # of the estimated error: what is expected to be missed by less is left
    )

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
    note: str | None = None

    @classmethod
    def restored(cls, numbers: dict[str, Any]) -> Self:
        """From the numbers of a checkpoint."""
        wall, offsets = Wall(*numbers["wall"]), numbers["offsets"]
        parts = {
            "wall": wall,
            "offsets": Offsets(**offsets | {"finest": Wall(*offsets["finest"])}),
            "line": Line(**numbers["line"]),
            "bracket": Bracket(**numbers["bracket"]),
        }
        return cls(**numbers | parts)

    @property
    def p0(self) -> float:
        """The mean pressure, in the program's units."""
        return exp(self.x)

    @property
    def aim(self) -> float:
        """The target, or what is nearest to it on this grid."""
        return self.target

    # -- from grid to grid
    # -------------------------------------------------------------------------

    def on_coarsest_grid(self) -> None:
        """A start on coarser grids begins, or one without any."""
        self.grids = 0
        self.offsets.begin()

    def on_next_grid(self, wall: Wall) -> float:
        """Go on on the next finer grid. Returns p0 to begin with.

        All grids have about the load of the finest one, where a coarser grid has another area or
        gap: so the contact is that of the load to begin with.
        """
        if self.grids:
            self.doubt, self.slope = hypot(GRID, self.line.doubt(self._way)), self.line.slope
            self.offsets.ends.append(self.x + self._way - self.offsets.ahead)
        offset = self.offsets.next(self.trend, self.by_steepness, self.wall, wall)
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

    # -- while a solver iterates
    # -------------------------------------------------------------------------

    def near(self, solver: Solver, progress: Progress) -> bool:
        """Whether the load of a solution on a coarser grid is as near as it need be; if not, it may
        be changed."""
        if not isfinite(self.straight(self.aim)) or self.corrections == FEW:
            return True
        self._read(*self._outlook(solver, progress))
        if abs(self._way) < COARSE:
            return self.line.doubt(self._way) < COARSE
        self._go_to(self.x + self._way, solver)
        return False

    def adjust(self, solver: Solver, progress: Progress, known: bool) -> bool:
        """Change the load of the solver where its own numbers say that it is wrong; returns
        whether. known: whether the solution is as accurate as asked."""
        if solver.iterations == self.looked:  # before a checkpoint
            return False
        self.looked = solver.iterations
        y, error, noise = self._outlook(solver, progress)
        now = self._present(solver, progress, y)
        self.missed = self._miss(now)
        return not (known and self.missed <= self.tolerance) and self._correct(
            solver, y, error, noise, now
        )

    @property
    def may_be_met(self) -> bool:
        """Whether it is worth asking the certificate."""
        return self.missed <= self.tolerance

    def met(self, solver: Solver, certificate: Certificate) -> bool:
        """Whether the certificate finds the quantity as prescribed."""
        return self._miss(self._of(solver, certificate)) <= self.tolerance

    def correct(self, solver: Solver, certificate: Certificate, sure: bool) -> bool:
        """Change the load of the solver where the certificate says that it is wrong; returns
        whether. sure: whatever its errors."""
        y = self._of(solver, certificate)
        error = (
            0.0
            if sure
            else PRESENT * self._error(y, certificate.gap_mean * solver.grid.a, *certificate.errors)
        )
        return self._correct(solver, y, error, self._noise(y, error), y)

    # -- the quantity: what a subclass has to tell
    # -------------------------------------------------------------------------

    def guess(self, load: Prescribed, surface: Surface) -> float:
        """A first guess of log p0."""
        raise NotImplementedError

    def straight(self, y: float) -> float:
        """A function of the quantity that rises about in proportion to log p0: -inf where nothing
        touches, inf where all does."""
        raise NotImplementedError

    def _expected(self, solver: Solver, outlook: Outlook) -> float:
        """The quantity by the numbers of the solver."""
        raise NotImplementedError

    def _present(self, solver: Solver, progress: Progress, expected: float) -> float:
        """The quantity as it is, as far as it is known."""
        return expected

    def _of(self, solver: Solver, certificate: Certificate) -> float:
        """The quantity, as the certificate finds it."""
        raise NotImplementedError

    def _error(
        self, y: float, gap: float, area_error: float, gap_error: float, pressure_error: float
    ) -> float:
        """Relative, of the quantity."""
        raise NotImplementedError

    def _noise(self, y: float, error: float, outlook: Outlook | None = None) -> float:
        """The standard deviation of a reading with that error, relative. outlook: what was read,
        None where it was a certificate."""
        return self.noise * error

    @property
    def least_miss(self) -> float:
        """Relative: what is missed by so much is met."""
        return self.tolerance

    def _miss(self, y: float) -> float:
        """Relative."""
        return abs(y / self.aim - 1)

    # -- what is known
    # -------------------------------------------------------------------------

    def _outlook(self, solver: Solver, progress: Progress) -> tuple[float, float, float]:
        """The quantity by the numbers of the solver, its estimated relative error, inf where it is
        not known, and its noise."""
        outlook = progress.outlook
        if (
            outlook is None
            or progress.estimates is None
            or not (progress.finite and progress.estimates[1] < VAGUE)
        ):
            return self.aim, inf, inf
        y, gap = self._expected(solver, outlook), outlook.gap_mean * solver.grid.a
        gap_error, pressure_error = progress.estimates
        gap_error = (
            max(gap_error, pressure_error) if progress.contact == solver.N else gap_error
        )  # nothing is open yet
        error = self._error(y, gap, pressure_error, gap_error, pressure_error)
        return y, error, self._noise(y, error, outlook)

    # -- corrections
    # -------------------------------------------------------------------------

    @property
    def _wanted(self) -> float:
        """What the straightened quantity is to be on this grid, at about the finest grid's load."""
        return self.straight(self.aim) + self.slope * self.offsets.ahead

    @property
    def _way(self) -> float:
        """By how much x is to change: not at all where this grid cannot have the target."""
        wanted = self.straight(self.aim)
        return (
            min(max(self.line.way_to(wanted) + self.offsets.ahead, -STEP), STEP)
            if isfinite(wanted)
            else 0.0
        )

    def _read(self, y: float, error: float, noise: float) -> None:
        """Learn that the quantity is about y at x, with that relative error; noise: its standard
        deviation, relative."""
        if not error < VAGUE:
            return
        f, wanted, farthest = self.straight(y), self._wanted, 2 * STEP
        noise = abs(f - self.straight(y / (1 + noise))) if isfinite(f) else BEYOND
        f = min(max(f, wanted - farthest), wanted + farthest)
        if self.last is not None:
            noise = hypot(
                noise, self.change * (f - self.last[1] - self.line.slope * (self.x - self.last[0]))
            )
        self.last = (self.x, f)
        self.line.read(f, min(max(noise, ROUNDING), farthest), self.slopes)

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
        missed = (
            min(self._miss(y), self._miss(now)) if (y > self.aim) == (now > self.aim) else 0.0
        )  # what changes may change sides
        return self._decide(solver, now, error, missed, error < SOLVED and missed > SURE * error)

    def _decide(
        self,
        solver: Solver,
        now: float,
        error: float,
        missed: float,
        sure: bool,
        way: float | None = None,
    ) -> bool:
        """Whether what is read calls for another load, which the solver then has. way: to the
        target, if not by the line."""
        settled = error < SETTLED * self.least_miss
        if not settled and self.corrections <= TRIALS:
            level, least = (
                self.straight(self.aim),
                hypot(SHARE * self.least_miss, self.worth * error),
            )
            due = abs(level - self.line.level) > abs(level - self.straight(self.aim / (1 + least)))
            return due and self._go_to(self.x + self._way, solver)
        if not (missed > self.tolerance if settled else sure):
            return False
        if (
            way is None
        ):  # to where it is near enough: what is changed by less is solved again sooner
            way = self.line.way_to(
                self.straight(
                    self.aim * (1 + np.copysign(ENOUGH * self.least_miss, now - self.aim))
                )
            )
        return (
            self._go_between(solver, now, error, way) if sure else self._go_to(self.x + way, solver)
        )

    def _go_between(self, solver: Solver, y: float, error: float, way: float) -> bool:
        """A correction by what is known for sure. way: to the target, by what seems so."""
        self._enclose(y, error)
        return self._go_to(self.bracket.within(self.x + min(max(way, -STEP), STEP)), solver)

    def _enclose(self, y: float, error: float) -> None:
        """x is surely too small or too large."""
        self.bracket.add(
            (self.x, y, error), self.straight(y) > self.straight(self.aim), SHARP * self.tolerance
        )
