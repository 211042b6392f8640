"""The search for a load at which the gap is nearly closed.

There the mean gap is about a power of how much less the load is than what closes the gap
everywhere, which is known beforehand (closing.py): beside that load the curve over log p0 has no
end to its slope, over log(p0/(closes_at - p0)) it is nearly straight.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, inf, log
from typing import TYPE_CHECKING

from .gap import GapSearch
from .offsets import Offsets

if TYPE_CHECKING:
    from ..bodies.base import Body
    from ..contact.contact import Contact
    from ..surface import Surface
    from .prescribed import Prescribed
    from .wall import Wall

NEARLY = 0.2  # of E* g_rms: full contact takes 0.3 to 20
SLOPE, DOUBT = (
    1.5,
    2.0,
    # 1 where a single point opens, up to 2.5 at the bottom of a bowl; of the first guess, one for a
    # single point
)


def _single(load: Prescribed, surface: Surface, body: Body) -> float:
    """How much less than what closes the gap opens a single point to the mean gap that is asked
    for, in the program's units."""
    grid = surface.grid
    return load.value / surface.height_unit * grid.N * float(body.near(grid)[0])


def nearly_closes(load: Prescribed, surface: Surface, body: Body) -> bool:
    """Whether a load is next to the one that closes the gap."""
    return load.quantity == "gap_mean" and _single(load, surface, body) < NEARLY


@dataclass
class Opening(GapSearch):
    """closes_at: the load that closes the gap, in the program's units."""

    kind = "opening"

    closes_at: float = 1.0

    @classmethod
    def of(cls, load: Prescribed, closed: Contact, wall: Wall) -> Opening:
        """closed: at the load that closes the gap. It begins where a single point would open so
        far."""
        closes_at = closed.p_mean / closed.pressure_unit
        x = log(max(closes_at / _single(load, closed.surface, closed.body) - 1, 1.0))
        target, offsets = load.value / closed.surface.slope, Offsets(wall)
        search = cls(target, closed.accuracy, x, SLOPE, DOUBT, wall, offsets, closes_at=closes_at)
        search.forget()
        return search

    @property
    def p0(self) -> float:
        """The mean pressure, in the program's units."""
        return self.closes_at / (1 + exp(-self.x))

    def straight(self, y: float) -> float:
        """A function of the mean gap that rises about in proportion to x."""
        return log(self.wall.top / y) if y > 0 else inf
