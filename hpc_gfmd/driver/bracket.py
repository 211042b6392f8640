"""Two loads that enclose the one that is searched for, and the next load between them.

Source: Chandrupatla, Adv. Eng. Softw. 28 (1997) 145, doi:10.1016/S0965-9978(96)00051-8.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite, nan, sqrt
from typing import NamedTuple


class Bound(NamedTuple):
    """A load that is known to be too small, or too large.

    Attributes
    ----------
    x : float
        The variable of the search.
    value : float
        What this load gives.
    distance : float
        A continuous function of the load with its zero at the target: below 0 where the load is too
        small. It may be infinite.
    plateau : float
        x of the first load on this side that gave the same value: further from the target, so that
        it takes less accuracy to know the value.
    """

    x: float
    value: float
    distance: float
    plateau: float = nan


@dataclass
class Bracket:
    """The loads nearest to the target so far.

    Attributes
    ----------
    low, high : Bound or None
        The largest load that is too small, the smallest that is too large.
    newest_is_low : bool
        Which of them was found last.
    replaced : Bound or None
        The bound in whose place that one came.
    """

    low: Bound | None = None
    high: Bound | None = None
    newest_is_low: bool = True
    replaced: Bound | None = None

    @property
    def is_closed(self) -> bool:
        """Whether the target is known to lie between two loads."""
        return self.low is not None and self.high is not None

    @property
    def bounds(self) -> list[Bound]:
        """The bounds that there are."""
        return [bound for bound in (self.low, self.high) if bound is not None]

    def excludes(self, x: float) -> bool:
        """Return whether a load is known to be too small or too large."""
        too_small = self.low is not None and x <= self.low.x
        too_large = self.high is not None and x >= self.high.x
        return too_small or too_large

    def add(self, bound: Bound, is_low: bool) -> None:
        """Add a load that misses the target, or one that is there, solved more accurately. A bound
        on the other side that contradicts it was wrong, and is dropped.

        Parameters
        ----------
        bound : Bound
            The load and what it gives; its `plateau` is found here.
        is_low : bool
            Whether the load is too small.
        """
        before = self.low if is_low else self.high
        plateau = bound.x
        if before is not None and before.value == bound.value:
            plateau = before.plateau
        bound = bound._replace(plateau=plateau)
        if before is None or before.x != bound.x:
            self.replaced = before
        self.newest_is_low = is_low
        if is_low:
            self.low = bound
            if self.high is not None and self.high.x <= bound.x:
                self.high = None
        else:
            self.high = bound
            if self.low is not None and self.low.x >= bound.x:
                self.low = None

    def between(self, meet: float) -> float:
        """Return x of the next load between two bounds: by inverse quadratic interpolation where
        that may be trusted, else the middle; first by a secant.

        Parameters
        ----------
        meet : float
            Difference of x below which two bounds are the same load. The next load keeps that
            distance from both.

        Returns
        -------
        float
        """
        assert self.low is not None
        assert self.high is not None
        newest, opposite = (self.low, self.high) if self.newest_is_low else (self.high, self.low)
        share = _share(newest, opposite, self.replaced)
        margin = min(meet / (self.high.x - self.low.x), 0.5)
        return newest.x + min(max(share, margin), 1 - margin) * (opposite.x - newest.x)


def _share(a: Bound, b: Bound, c: Bound | None) -> float:
    """Return where between a, the newest bound, and b the zero is expected; c: the bound that a
    replaced."""
    distances = [bound.distance for bound in (a, b, c) if bound is not None]
    if not all(isfinite(distance) for distance in distances) or a.distance == b.distance:
        return 0.5
    if c is None:
        return a.distance / (a.distance - b.distance)
    if c.distance in (a.distance, b.distance):
        return 0.5
    xi = (a.x - b.x) / (c.x - b.x)
    phi = (a.distance - b.distance) / (c.distance - b.distance)
    if not (0 < xi < 1 and 1 - sqrt(1 - xi) < phi < sqrt(xi)):
        return 0.5
    of_b = a.distance / (b.distance - a.distance) * c.distance / (b.distance - c.distance)
    of_c = a.distance / (c.distance - a.distance) * b.distance / (c.distance - b.distance)
    return of_b + of_c * (c.x - a.x) / (b.x - a.x)
