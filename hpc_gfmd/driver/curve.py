"""What a sweep knows of the loads before: where the search for the pressure of the next one
begins."""

from __future__ import annotations

from collections.abc import Sequence
from math import copysign, isfinite, log
from typing import TYPE_CHECKING

from .line import UNKNOWN, Line
from .offsets import Offsets
from .opening import Opening
from .search import Search
from .searches import SEARCHES

if TYPE_CHECKING:
    from ..contact.contact import Contact
    from ..surface import Surface
    from .closing import Closing
    from .prescribed import Prescribed
    from .wall import Wall

FAR = log(5.0)  # log p0 of two loads, that have to do with each other no more
BEND = 0.3  # by which a slope may differ from that of the last secant, relative
DOUBT, KNOWN = (
    1.0,
    0.08,
)  # standard deviation of a first guess of log p0; of the slope between two loads, relative


class Curve:
    """What a sweep knows of the loads before, for a first guess: points, the last three of {"x":
    log p0, quantity: value}; slopes and offsets, {quantity: slope of the Search's line, and offsets
    that it found}."""

    def __init__(
        self,
        points: Sequence[dict[str, float]] = (),
        slopes: dict[str, float] | None = None,
        offsets: dict[str, list[float]] | None = None,
    ):
        self.points, self.slopes, self.offsets = (
            list(points),
            dict(slopes or {}),
            dict(offsets or {}),
        )

    def add(self, x: float, contact: Contact, search: Search | Closing | None = None) -> None:
        """A load that was solved: log p0, its Contact, and what found it."""
        certificate, a = contact.certificate, contact.surface.grid.a
        self.points = [
            *self.points[-2:],
            {
                "x": float(x),
                "a_r": contact.contact_points / contact.N,
                "gap_mean": certificate.gap_mean * a,
                "approach": certificate.approach * a,
            },
        ]
        if isinstance(search, Search) and not isinstance(search, Opening):
            self.slopes[search.quantity] = search.line.slope
            if search.offsets.ends:
                self.offsets[search.quantity] = search.offsets.found(search.x)

    def search(self, load: Prescribed, surface: Surface, wall: Wall, tolerance: float) -> Search:
        """The Search for a load on a surface; wall: of its grid."""
        kind = load.quantity
        found, target = SEARCHES[kind], load.value if kind == "a_r" else load.value / surface.slope
        offsets = Offsets(wall, list(self.offsets.get(kind, ())))
        search = found(
            target, tolerance, 0.0, self.slopes.get(kind, found.usual), DOUBT, wall, offsets
        )
        known = [
            (point["x"], f) for point in self.points if isfinite(f := search.straight(point[kind]))
        ]
        if known:
            self._extrapolate(search, known)
        else:
            search.x = search.guess(load, surface)
            search.forget()
        return search

    def _extrapolate(self, search: Search, known: list[tuple[float, float]]) -> None:
        """known: (log p0, straightened quantity) of the last loads."""
        kind, wanted, (x, f) = search.quantity, search.straight(search.aim), known[-1]
        near = [
            point for point in known if abs(point[0] - x) < FAR or kind not in self.slopes
        ]  # slopes elsewhere are of no use
        secants = [
            ((x0 + x1) / 2, (f1 - f0) / (x1 - x0))
            for (x0, f0), (x1, f1) in zip(near, near[1:])
            if x0 != x1
        ]
        if secants and search.slopes[0] < secants[-1][1] < search.slopes[1]:
            middle, search.slope = secants[-1]
            bend = (
                (search.slope - secants[0][1]) / (middle - secants[0][0])
                if len(secants) > 1 and middle != secants[0][0]
                else 0.0
            )
            change = search.bent * bend * (x + 0.5 * (wanted - f) / search.slope - middle)
            search.slope *= 1 + min(max(change / search.slope, -BEND), BEND)
        way = (wanted - f) / search.slope
        if abs(way) > FAR:  # what is known here says nothing of there
            near_end = copysign(FAR, way)
            way = near_end + (wanted - f - near_end * search.slope) / search.usual
        search.x = x + way
        search.line = Line.guessed(
            f, search.slope, search.least_miss, KNOWN if secants else UNKNOWN
        )
        search.line.move(search.x - x)
        search.doubt = search.line.doubt(0.0)
