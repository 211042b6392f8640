"""The search for a load that gives an area.

The area of a grid is a number of points. It is met to the accuracy asked for or to one point; where
it jumps by more, as in ordered walls whose asperities touch all at once (staircase.py), the nearer
side of the jump is taken, and `note` says so.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, log
from statistics import NormalDist
from typing import TYPE_CHECKING

import numpy as np

from .bracket import Bracket
from .search import SETTLED, SHARE, STEP, Search
from .staircase import Jump, Staircase

if TYPE_CHECKING:
    from ..certificate.certificate import Certificate
    from ..solvers.base import Outlook, Progress, Solver
    from ..surface import Surface
    from .prescribed import Prescribed

STEEP, STEEPER, NARROW = (
    2.0,
    4.0,
    1e-3,
)  # times the usual slope: the area may jump; it jumps, within the tolerance, or this
SEEN, LARGE = (
    0.03,
    3.0,
)  # error of the pressure field at which a jump is seen; times what may be missed, a large one
SAME = 0.1  # of a jump: how near its side is to what was read
POINT = 1.001  # by which the area may be missed


@dataclass
class AreaSearch(Search):
    """side, jump: where the area jumps, the side that is taken, and by how much."""

    quantity = kind = "a_r"
    usual, slopes, bent, trend, by_steepness = (
        1.0,
        (0.4, 2.5),
        0.5,
        0.5,
        True,
    )  # slopes: without jumps
    noise, change, worth = 0.1, 0.3, 0.05

    side: float = 0.0
    jump: float = 0.0

    @property
    def aim(self) -> float:
        """The target, or the least area that this grid has at any load."""
        return max(self.target, self.wall.highest / self.wall.points)

    @property
    def _too_small(self) -> bool:
        """Whether no load of this grid has so small an area: the least is taken, at any load that
        has no more."""
        return self.aim > self.target * (1 + self.least_miss)

    @property
    def _point(self) -> float:
        """A point over the target: that much more or less is nothing."""
        return POINT / (self.aim * self.wall.points)

    @property
    def least_miss(self) -> float:
        """Relative: what is missed by so much is met."""
        return max(self.tolerance, self._point)

    def _miss(self, y: float) -> float:
        miss = max(y / self.aim - 1, 0.0) if self._too_small else abs(y / self.aim - 1)
        return miss if miss > self._point else 0.0

    def guess(self, load: Prescribed, surface: Surface) -> float:
        """A first guess of log p0: a_r is about 2 p*."""
        return log(self.target / 2)

    def straight(self, y: float) -> float:
        """That of Persson's theory, a_r = erf(c p0)."""
        y = min(y, 1 - 0.25 / self.wall.points)
        return log(NormalDist().inv_cdf((1 + y) / 2)) if y > 0 else -inf

    def _expected(self, solver: Solver, outlook: Outlook) -> float:
        return outlook.contact / solver.N

    def _present(self, solver: Solver, progress: Progress, expected: float) -> float:
        return progress.contact / solver.N

    def _of(self, solver: Solver, certificate: Certificate) -> float:
        return certificate.contact / solver.N

    def _error(
        self, y: float, gap: float, area_error: float, gap_error: float, pressure_error: float
    ) -> float:
        return area_error

    def _noise(self, y: float, error: float, outlook: Outlook | None = None) -> float:
        if outlook is not None:
            return outlook.doubt / outlook.contact
        settled = error < SETTLED * self.least_miss
        return self.noise * error + (0.0 if settled else 0.5 / max(y * self.wall.points, 0.5))

    @property
    def may_be_met(self) -> bool:
        """Whether it is worth asking the certificate."""
        return self.note is not None or super().may_be_met

    def met(self, solver: Solver, certificate: Certificate) -> bool:
        """Whether the certificate finds the area as prescribed, or on the side of a jump that was
        chosen."""
        y = self._of(solver, certificate)
        met = self._miss(y) <= self.tolerance
        if (
            self.note is not None
            and not met
            and abs(y - self.side) > max(POINT / self.wall.points, SAME * self.jump)
        ):
            self.note, self.bracket = None, Bracket()  # there was no jump
        if met and self._too_small:
            self.note = f"a_r jumps from 0 to {self.aim:.4g}: the least at any load"
        return met or self.note is not None

    def _decide(
        self,
        solver: Solver,
        now: float,
        error: float,
        missed: float,
        sure: bool,
        way: float | None = None,
    ) -> bool:
        """As any search, unless the area jumps over the target; the last points are aimed at by how
        near each of them is."""
        if self._too_small:
            return missed > self.tolerance and self._go_to(self.x - STEP, solver)
        if error < SEEN and self._miss(now) > self.tolerance and not solver.closing:
            wanted, allowed = (
                (self.aim - now) * self.wall.points,
                self.least_miss * self.aim * self.wall.points,
            )
            stairs = Staircase.of(
                solver, round(now * self.wall.points), wanted, self._usual_rate(now)
            )
            jump = stairs and self._large(stairs.jump(abs(wanted), error), abs(wanted))
            if jump:
                if sure:
                    self._enclose(now, error)
                if self._enclosed:
                    return self._jump(solver)
                return self._go_beside(jump, now, solver, sure)
            self.note = None
            if stairs:
                way = float(
                    np.copysign(
                        stairs.way_between(abs(wanted) - allowed, abs(wanted) + allowed), wanted
                    )
                )
        return self.note is None and super()._decide(solver, now, error, missed, sure, way)

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
        """As any search, but where nothing changes the way is doubled, and a jump may be all there
        is between the bounds."""
        here = (self.x, y, error)
        stands = self.bracket.stands(
            here, self.straight(y) > self.straight(self.aim), 0.5 / self.wall.points
        )
        self._enclose(y, error)
        if self._enclosed:
            return self._jump(solver)
        x = self.x + min(max(np.copysign(max(abs(way), 2 * stands), way), -STEP), STEP)
        return self._go_to(self.bracket.within(inf if self._rise() > STEEP else x), solver)

    def _rise(self) -> float:
        """The slope that the area has between the bounds, at least; 0 where it may not rise."""
        low, high = self.bracket.low, self.bracket.high
        if low is None or high is None or (high[1] - low[1]) * self.wall.points < 2 * POINT:
            return 0.0
        return (
            self.straight(high[1] / (1 + high[2])) - self.straight(low[1] * (1 + low[2]))
        ) / self.bracket.width

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
        self.note = (
            f"a_r jumps from {low[1]:.4g} to {high[1]:.4g}: the nearer to what was asked for"
        )
        return x != self.x and self._go_to(x, solver)
