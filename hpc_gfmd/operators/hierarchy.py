"""The levels below a grid as the multilevel preconditioner has them: from which to which one rank
sends what, what they weigh, and from which one on a single rank has them all. No field.

Every rank restricts to the window of coarse rows that its fine rows touch; windows are added up on
the ranks that own the rows: those beside the fine rows, or fewer and fewer of them as levels get
small (coarsening.py). The rest of the levels is small enough for rank 0 alone.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import DTypeLike

from ..bodies.base import Body
from ..parallel.coarsening import Level, Transfer, agglomerated, levels
from ..parallel.grid import Grid
from ..parallel.halo import Windows
from .deflation import GapMode
from .nominal import NominalArea

COARSEST_POINTS = 128 * 128  # levels of at most this many points are swept by rank 0
RANK_POINTS = 2048  # of a level on one rank, at least: fewer take less time than a message


@dataclass(frozen=True)
class Step:
    """From one level to the next coarser one, as one rank sees it. starts: first row of every rank
    on the coarse level, and their number; windows: between the rows that ranks write to and those
    that they own; fields: that are restricted."""

    transfer: Transfer
    starts: np.ndarray
    windows: Windows
    fields: int

    @property
    def owned(self) -> int:
        """Number of coarse rows that this rank owns."""
        return int(self.starts[self.windows.rank + 1] - self.starts[self.windows.rank])

    @property
    def in_place(self) -> bool:
        """Whether the rows that ranks own lie in their windows, between a row before and after."""
        return np.array_equal(self.starts, self.transfer.coarse_starts)

    @property
    def window_shape(self) -> tuple[int, int, int]:
        """Shape of the fields in this rank's window."""
        return self.fields, self.transfer.window_rows, self.transfer.m[1]

    @property
    def owned_shape(self) -> tuple[int, int, int]:
        """Shape of the fields on the rows that this rank owns, with a row before and after."""
        return self.fields, self.owned + 2 if self.owned else 0, self.transfer.m[1]

    @property
    def traffic(self) -> tuple[int, int]:
        """(bytes for an itemsize of 1, messages) that this rank sends in a sweep, of all fields
        down and one up."""
        down, up = self.windows.sent_rows(True), self.windows.sent_rows(False)
        rows = self.fields * sum(down.values()) + sum(up.values())
        return rows * self.transfer.m[1], len(down) + len(up)


def steps_of(
    grid: Grid, dtype: DTypeLike, coarsest_points: int | None = None
) -> tuple[list[Step], list[Level]]:
    """Return the Steps down to the first level that rank 0 has alone, and the levels, of the rank
    that grid.comm says. coarsest_points: see COARSEST_POINTS."""
    most = COARSEST_POINTS if coarsest_points is None else coarsest_points
    hierarchy, rank = levels(grid), grid.comm.rank
    if len(hierarchy) == 1:  # a single point: a level that equals it, so that there is always one
        hierarchy = hierarchy * 2
    steps: list[Step] = []
    starts = grid.starts
    for fine, coarse in zip(hierarchy, hierarchy[1:]):
        transfer = Transfer(fine.n, coarse.n, starts, rank, dtype)
        points = coarse.n[0] * coarse.n[1]
        last = points <= most or coarse is hierarchy[-1]
        starts = agglomerated(transfer.coarse_starts, points, points if last else RANK_POINTS)
        windows = Windows(rank, starts, transfer.lo, transfer.hi)
        # p on F and the indicator of A; from the grid itself x, too
        steps.append(Step(transfer, starts, windows, 2 if steps else 3))
        if last:
            break
    return steps, hierarchy


def traffic_of(steps: Sequence[Step], itemsize: int) -> tuple[int, int]:
    """Return (bytes, messages) that a rank sends in a sweep."""
    nbytes, messages = np.sum([step.traffic for step in steps], axis=0)
    return int(nbytes) * itemsize, int(messages)


class Hierarchy:
    """What the sweep of a grid, body and precision needs besides memory for fields, made once.

    steps, levels: see `steps_of`; weights, softness: of every level; area: see nominal.py; nominal:
    of every level that ranks share, what the indicator of the nominal area is a product of, on this
    rank's rows.
    """

    def __init__(self, grid: Grid, body: Body, dtype: np.dtype, coarsest_points: int | None = None):
        self.steps, self.levels = steps_of(grid, dtype, coarsest_points)
        # a single point has one weight for its two levels
        weights, self.softness = (
            np.resize(a, len(self.levels)) for a in (body.weights(grid), body.softness(grid))
        )
        self.weights, alone = weights.astype(dtype), len(self.steps)
        self.area = NominalArea(grid, self.levels, self.softness)
        starts, rank = [grid.starts, *(step.starts for step in self.steps)], grid.comm.rank
        self.nominal = [
            (x[rows[rank] : rows[rank + 1]].astype(dtype), y.astype(dtype))
            for (x, y), rows in zip(self.area.s, starts)
        ]
        self.gap_mode = GapMode(grid, body, self.levels[alone:], self.weights[alone:])
