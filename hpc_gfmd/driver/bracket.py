"""The two loads that enclose the one that is sought, and the next load to try between them.

Source: Chandrupatla, Adv. Eng. Softw. 28 (1997) 145, doi:10.1016/S0965-9978(96)00051-8.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite, nan, sqrt
from typing import NamedTuple


class Bound(NamedTuple):
    """A solved load that is certainly too small, or certainly too large.

    Attributes
    ----------
    x : float
        The variable of the search, which rises with the load.
    value : float
        The sought quantity at this load, for example the area.
    distance : float
        A continuous function of the load that is 0 at the target and below 0 if the load is too
        small. It may be infinite.
    plateau : float
        x of the first load on this side with the same value. It is further from the target, where
        a less accurate solution suffices to know the value.
    """

    x: float
    value: float
    distance: float
    plateau: float = nan


@dataclass
class Bracket:
    """The solved loads nearest to the target, one on each side.

    Attributes
    ----------
    low, high : Bound or None
        The largest load that is too small and the smallest that is too large; None until there is
        one.
    newest_is_low : bool
        Whether `low` was added last, not `high`.
    replaced : Bound or None
        The bound that the newest one replaced.
    """

    low: Bound | None = None
    high: Bound | None = None
    newest_is_low: bool = True
    replaced: Bound | None = None

    @property
    def is_closed(self) -> bool:
        """Whether there is a bound on both sides of the target."""
        return self.low is not None and self.high is not None

    @property
    def bounds(self) -> list[Bound]:
        """The existing bounds in a list, low before high; it may be empty."""
        return [bound for bound in (self.low, self.high) if bound is not None]

    def excludes(self, x: float) -> bool:
        """Return whether x is not strictly between the bounds."""
        too_small = self.low is not None and x <= self.low.x
        too_large = self.high is not None and x >= self.high.x
        return too_small or too_large

    def add(self, bound: Bound, is_low: bool) -> None:
        """Replace the bound of one side by a new one.

        It may be the same load, solved more accurately. If the bound of the other side contradicts
        the new one, it was wrong and is dropped.

        Parameters
        ----------
        bound : Bound
            The new bound. Its `plateau` is ignored, and set here.
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
        """Return x of the next load to try between the two bounds, which must exist.

        It follows from a secant at first, later from inverse quadratic interpolation if
        Chandrupatla's conditions hold; else it is the middle. Changes nothing.

        Parameters
        ----------
        meet : float
            Smallest distance in x that the next load keeps from both bounds, if there is room.

        Returns
        -------
        float
            Strictly between the bounds, apart from rounding errors.
        """
        assert self.low is not None
        assert self.high is not None
        newest, opposite = (self.low, self.high) if self.newest_is_low else (self.high, self.low)
        share = _share(newest, opposite, self.replaced)
        margin = min(meet / (self.high.x - self.low.x), 0.5)
        return newest.x + min(max(share, margin), 1 - margin) * (opposite.x - newest.x)


def _share(a: Bound, b: Bound, c: Bound | None) -> float:
    """Return where the zero of `distance` is expected, as a share of the way from a to b.

    a is the newest bound, b the opposite one, c the one that a replaced. 0.5 if the interpolation
    cannot be trusted.
    """
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
