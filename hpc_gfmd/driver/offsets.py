"""From grid to grid: how much more load the same area or gap takes on finer ones."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import log

from .wall import Wall

MOST = log(2.0)


@dataclass
class Offsets:
    """Of log p0 that takes the target. finest: the Wall of the finest grid; known: offsets from
    every grid to the next finer one as they were found at another load, coarsest first, or none;
    ends: what the grids before took, in log p0; step: what slopes told of the last offset; ahead:
    how far it is likely to be from this grid to the finest one."""

    finest: Wall
    known: list[float] = field(default_factory=list)
    ends: list[float] = field(default_factory=list)
    step: float = 0.0
    ahead: float = 0.0

    def begin(self) -> None:
        """The coarsest grid comes next."""
        self.ends, self.step = [], 0.0

    def next(self, trend: float, by_steepness: bool, before: Wall, wall: Wall) -> float:
        """Go on to the grid of `wall`; returns the offset to it: as at another load, or as slopes
        tell where the target takes a load in proportion to these, and the grids before (trend: so
        much of what they changed beside)."""
        k = len(self.ends)
        if self.known:
            self.ahead = sum(self.known[k:])
            return self.known[k - 1] if k else 0.0
        goes = by_steepness and min(wall.steepness, before.steepness, self.finest.steepness) > 0
        last = self.ends[-1] - self.ends[-2] - self.step if k > 1 else 0.0
        self.step = log(wall.steepness / before.steepness) if goes and k else 0.0
        more, finer = min(max(trend * last, -MOST), MOST), log(self.finest.points / wall.points, 4)
        self.ahead = (
            log(self.finest.steepness / wall.steepness) if goes else 0.0
        ) + more * trend * (1 - trend**finer) / (1 - trend)
        return self.step + more

    def found(self, x: float) -> list[float]:
        """From every grid to the next finer one; x: what the finest takes."""
        return [b - a for a, b in zip(self.ends, [*self.ends[1:], x])]
