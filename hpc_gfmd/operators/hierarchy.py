"""The levels of the preconditioner, (5) in docs/method.md: rows of each rank, what ranks send.

Every rank restricts its rows through several levels first: its windows hold its parts of sums over
ranks. Then shared rows are added up, in one message to a neighbour, and each interpolates from its
own windows. Below FEWEST_ROWS rows a level is gathered on fewer ranks (coarsening.py), which go on
likewise. The coarsest levels are complete on each remaining rank, which sweeps them alone.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import DTypeLike

from ..bodies.base import Body
from ..parallel.coarsening import Level, Transfer, agglomerated, levels, owned_rows
from ..parallel.grid import Grid
from ..parallel.halo import Overlaps, Windows
from .coarsest import LevelTables
from .deflation import GapMode, level_of_mode
from .nominal import NominalArea

# Chosen: levels of at most so many points are not shared by ranks, each sweeps them alone. One
# process does so with all: shared levels take the same pairs, but a solve of n = 128 to 1024 with
# them 15 to 30 % more time.
COARSEST_POINTS = 64 * 64
# Nor are those of at most so many points shared of which a rank would have less than FEWEST_ROWS.
UNGATHERED_POINTS = 128 * 128
FEWEST_ROWS = 2  # of a level on one rank: with fewer, windows reach beyond neighbours
GATHERED_ROWS = 4  # that ranks have at least where rows are gathered


@dataclass(frozen=True)
class Step:
    """One rank's step from a level to the next coarser one, which has fewer rows and perhaps fewer
    ranks.
    """

    transfer: Transfer  # of its fine rows to its window of coarse rows
    # (ranks + 1,): first fine row that each rank counts in sums, and their number; the rows of
    # neighbours may overlap
    counted: np.ndarray
    fields: int  # of the coarse level: r, t, and on level 1 also K d
    windows: Windows | None  # sends window rows to the ranks that gather them; None: all go on
    starts: np.ndarray  # (ranks + 1,): first coarse row with which each rank goes on

    @property
    def window_rows(self) -> int:
        """Number of rows of this rank's window."""
        rank = self.transfer.rank
        return int(self.transfer.hi[rank] - self.transfer.lo[rank])

    @property
    def window_shape(self) -> tuple[int, int, int]:
        """Shape of the fields in this rank's window, with a row before and after."""
        return self.fields, _with_ends(self.window_rows), self.transfer.m[1]

    @property
    def owned(self) -> int:
        """Number of coarse rows that this rank goes on with: its window, or its gathered rows."""
        if self.windows is None:
            return self.window_rows
        return int(self.starts[self.windows.rank + 1] - self.starts[self.windows.rank])

    @property
    def owned_shape(self) -> tuple[int, int, int]:
        """Shape of the fields on these `owned` rows, with a row before and after."""
        return self.fields, _with_ends(self.owned), self.transfer.m[1]

    @cached_property
    def overlaps(self) -> Overlaps:
        """The rows that this rank's window shares with the windows of other ranks."""
        transfer = self.transfer
        return Overlaps(transfer.rank, transfer.lo, transfer.hi, transfer.m[0])

    @property
    def counted_rows(self) -> tuple[int, int]:
        """Range of this rank's fine rows, from the first one, that it counts in sums."""
        rank = self.transfer.rank
        begin = self.transfer.fine[0]
        return int(self.counted[rank] - begin), int(self.counted[rank + 1] - begin)

    @property
    def ranks(self) -> list[int]:
        """The ranks whose window of coarse rows is not empty."""
        return np.flatnonzero(self.transfer.hi > self.transfer.lo).tolist()


def _with_ends(rows: int) -> int:
    """Return the number of rows with one before and one after; 0 if there are none."""
    return rows + 2 if rows else 0


def steps_of(
    grid: Grid, dtype: DTypeLike, coarsest_points: int | None = None
) -> tuple[list[Step], list[Level]]:
    """Return the steps between shared levels, and all levels, finest first. Not collective. A rank
    has alone those of at most coarsest_points points (default: COARSEST_POINTS; one process: all),
    and the gap mode's with all coarser.
    """
    rank = grid.comm.rank
    if coarsest_points is None:
        coarsest_points = COARSEST_POINTS if grid.comm.size > 1 else grid.cell_points
    hierarchy = levels(grid)
    if len(hierarchy) == 1:  # a single point: a level that equals it, so that there is always one
        hierarchy = hierarchy * 2
    mode_level = level_of_mode(hierarchy)
    steps: list[Step] = []
    counted = grid.starts
    begin, end = counted[:-1], counted[1:]
    for k, (fine, coarse) in enumerate(zip(hierarchy, hierarchy[1:])):
        transfer = Transfer(fine.n, coarse.n, begin, end, rank, dtype)
        starts = owned_rows(counted, fine.n[0], coarse.n[0])
        points = coarse.n[0] * coarse.n[1]
        alone = points <= coarsest_points or coarse is hierarchy[-1] or k + 1 == mode_level
        begin, end = transfer.lo, transfer.hi
        has_rows = end > begin
        windows = None
        has_few_rows = np.sum(has_rows) > 1 and np.diff(starts)[has_rows].min() < FEWEST_ROWS
        if not alone and has_few_rows and points <= UNGATHERED_POINTS:
            alone = True
        elif not alone and has_few_rows:
            starts = agglomerated(starts, coarse.n[0], GATHERED_ROWS)
            windows = Windows(rank, starts, begin, end)
            begin, end = starts[:-1], starts[1:]
        # p on F and the indicator of A; from the grid itself K d on F, too
        steps.append(Step(transfer, counted, 2 if steps else 3, windows, starts))
        counted = starts
        if alone:
            break
    return steps, hierarchy


class Hierarchy:
    """What a sweep needs besides memory, shared by sweeps of one grid, body and precision.

    `steps`: between the levels that ranks share; `levels`: all, finest first. `weights`: stiffness
    of each; `softness`: what each adds to S; `area`: the nominal area on each; `nominal`: its
    factors on this rank's rows of the shared levels.
    """

    def __init__(self, grid: Grid, body: Body, dtype: np.dtype, coarsest_points: int | None = None):
        self.steps, self.levels = steps_of(grid, dtype, coarsest_points)
        # a single point has one weight for its two levels
        count = len(self.levels)
        self.softness = np.resize(body.softness(grid), count)
        self.weights = np.resize(body.weights(grid), count).astype(dtype)
        self.area = NominalArea(grid, self.levels, self.softness)
        self.nominal = [
            (np.take(x, np.arange(*step.transfer.fine), mode="wrap").astype(dtype), y.astype(dtype))
            for (x, y), step in zip(self.area.s, self.steps)
        ]
        self.gap_mode = GapMode(grid, body, self.levels, self.weights)

    @cached_property
    def coarsest_tables(self) -> LevelTables:
        """Tables of the levels that a rank has alone."""
        alone = slice(len(self.steps), None)
        return LevelTables(
            self.levels[alone],
            self.weights[alone],
            self.area.weights[alone],
            self.steps[-1].fields,
            self.area.s[alone],
        )
