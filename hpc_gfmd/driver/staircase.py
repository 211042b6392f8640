"""How the area goes on from a state that is nearly solved: which points come next, and how far it
is to them.

An area is a number of points. When the load rises the points of the smallest gap come into contact,
when it falls those of the least pressure leave it. How many of them are about alike tells where the
area jumps, as in ordered walls whose asperities touch all at once, before anything was solved on
the other side. While the edge of a contact stands still the gap of a point beyond it falls in
proportion to the load, and that it moves by points tells more than how fast it moves. Within, the
distance of a point from the edge goes as the square of its pressure, and the edge moves in
proportion to the load; a point has a pressure in proportion to the load as soon as it touches,
which counts for those next to the edge.

How fast all that goes follows from the usual rate, unless points go in steps that tell nothing of
one: then from the contacts as they are, whose pressures, and the gaps beside them, change about as
the load does.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..kernels.margins import NUMBERS, count_margins, number_of

if TYPE_CHECKING:
    from ..solvers.base import Solver

EDGE, NEXT = (
    0.25,
    2.0,
)  # share of the contact within which its edge is, about; times its pressure: next to the edge
NEAR, FEW = (
    0.05,
    16.0,
)  # share of the contact, and points, at least, that leave it at the usual rate
# of the way, and once the error of the pressure: points whose ways differ by less go together
ALIKE = 0.003
INTO = 0.3  # of the way from a jump to the next points: where its other side is looked for
CONTRAST = 2.5  # times as many as usually go within such a way: a jump
LIKE, STEP = (
    1.05,
    0.7,
    # ratio of ways, share of those that go at the usual rate: where more go so much together the
    # rate is unknown
)
POINT, ALONE = (
    2.5,
    0.6,
    # times the compliance of the shortest wave: of a point; of the way of a point that others do
    # not press on
)


class Jump(NamedTuple):
    """before, after: points that have gone on its sides; to_before, to_after: changes of log p0
    that lead there, without sign."""

    before: float
    after: float
    to_before: float
    to_after: float


class Staircase(NamedTuple):
    """gone: points that have gone after each step; way: how far it is to there, in log p0, without
    sign; rate: points per log p0 that go, usually."""

    gone: np.ndarray
    way: np.ndarray
    rate: float

    @classmethod
    def of(cls, solver: Solver, contact: int, points: float, rate: float) -> Staircase | None:
        """Down or up from a state of so many points in contact, as the sign of the points that are
        wanted says; None if there are not so many. Collective."""
        less, wanted = points < 0, abs(points)
        counts = np.zeros(NUMBERS, np.int64)
        count_margins(solver.g, solver.p, solver.grid.inside, less, counts)
        total = solver.grid.comm.sum(counts)
        there = np.flatnonzero(total)
        gone, margin = np.cumsum(total[there]), number_of(there)
        if not len(gone) or gone[-1] < wanted + 1:
            return None
        way = (
            margin**2 + NEXT * margin * margin[np.searchsorted(gone, EDGE * gone[-1])]
            if less
            else margin
        )
        usual = np.searchsorted(gone, min(max(2 * wanted, NEAR * contact, FEW), gone[-1] / 2))
        if not way[usual] > 0:
            return None
        first, last = np.searchsorted(way, [way[usual] / LIKE, way[usual] * LIKE])
        if gone[last - 1] - (gone[first - 1] if first else 0) > STEP * gone[usual]:
            pressures = margin if less else margin * solver.problem.body.scale(solver.grid) / POINT
            return cls(gone, ALONE * pressures * contact / (solver.grid.N * solver.p0), rate)
        return cls(gone, way * gone[usual] / (way[usual] * rate), rate)

    def jump(self, wanted: float, error: float) -> Jump | None:
        """The jump at which so many points go, None where they go on smoothly. error: relative, of
        the pressure field."""
        gone, way = self.gone, self.way
        here = way[np.searchsorted(gone, np.floor(wanted), "right")]
        reach = ALIKE * here + error
        first, last = np.searchsorted(way, [here - reach, here + reach])
        before, after = gone[first - 1] if first else 0.0, gone[last - 1]
        if after - before < CONTRAST * self.rate * 2 * reach:
            return None
        return Jump(before, after, self.way_to(before), self.way_to(after))

    def way_to(self, points: float) -> float:
        """How far it is to where so many have gone, and the next have not."""
        k = int(np.searchsorted(self.gone, np.floor(points), "right"))
        before = self.way[k - 1] if k else 0.0
        return (
            float(before + INTO * (self.way[min(k, len(self.way) - 1)] - before))
            if points >= 1
            else 0.0
        )

    def way_between(self, enough: float, most: float) -> float:
        """How far it is to where at least so many have gone, and no more than so many."""
        last = len(self.way) - 1
        there = min(int(np.searchsorted(self.gone, enough)), last)
        beyond = min(int(np.searchsorted(self.gone, most, "right")), last)
        return float(self.way[there] + INTO * (self.way[beyond] - self.way[there]))
