"""Loads between which the one is that is asked for."""

from __future__ import annotations

from dataclasses import dataclass

Bound = tuple[float, float, float]


@dataclass
class Bracket:
    """low, high: (log p0, what the quantity is there, its relative error) where it is surely too
    small, and too large; None where no such load is known."""

    low: Bound | None = None
    high: Bound | None = None

    def add(self, bound: Bound, large: bool, least: float) -> None:
        """A load that is surely too large, or too small. A bound on the other side that this
        contradicts was none, nor were both if they are nearer to each other than `least`."""
        if large:
            self.high, self.low = bound, self.low if self.low and self.low[0] < bound[0] else None
        else:
            self.low, self.high = (
                bound,
                self.high if self.high and self.high[0] > bound[0] else None,
            )
        if self.width < least:
            self.low = self.high = None

    @property
    def width(self) -> float:
        """Of log p0; inf where there is but one bound."""
        return self.high[0] - self.low[0] if self.low and self.high else float("inf")

    def within(self, x: float) -> float:
        """x, or the middle if that is not between the bounds."""
        return (
            0.5 * (self.low[0] + self.high[0])
            if self.low and self.high and not self.low[0] < x < self.high[0]
            else x
        )

    def stands(self, bound: Bound, large: bool, least: float) -> float:
        """How far it is from the last bound on the side of this one, 0 if the quantity has changed
        by `least` on the way."""
        last = self.high if large else self.low
        return abs(bound[0] - last[0]) if last and abs(last[1] - bound[1]) < least else 0.0
