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
    """From one level to the next coarser one, as one rank sees it.

    Attributes
    ----------
    transfer : Transfer
        This rank's part of restriction and interpolation.
    starts : array (ranks + 1,)
        First row of every rank on the coarse level, and the number of rows.
    windows : Windows
        Between the rows that ranks write to and those that they own.
    fields : int
        Number of fields that are restricted.
    """

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
        down = self.windows.sent_rows(True)
        up = self.windows.sent_rows(False)
        rows = self.fields * sum(down.values()) + sum(up.values())
        return rows * self.transfer.m[1], len(down) + len(up)


def steps_of(
    grid: Grid, dtype: DTypeLike, coarsest_points: int | None = None
) -> tuple[list[Step], list[Level]]:
    """Decide which levels ranks share, and which rank 0 has alone.

    Parameters
    ----------
    grid : Grid
        The finest level; its communicator says which rank is meant.
    dtype : dtype
        Precision of the tables.
    coarsest_points : int, optional
        Levels of at most so many points are rank 0's alone; default: COARSEST_POINTS.

    Returns
    -------
    steps : list of Step
        Down to the first level that rank 0 has alone.
    levels : list of Level
        All of them, finest first.
    """
    alone_points = COARSEST_POINTS if coarsest_points is None else coarsest_points
    hierarchy = levels(grid)
    rank = grid.comm.rank
    if len(hierarchy) == 1:  # a single point: a level that equals it, so that there is always one
        hierarchy = hierarchy * 2
    steps: list[Step] = []
    starts = grid.starts
    for fine, coarse in zip(hierarchy, hierarchy[1:]):
        transfer = Transfer(fine.n, coarse.n, starts, rank, dtype)
        points = coarse.n[0] * coarse.n[1]
        alone = points <= alone_points or coarse is hierarchy[-1]
        starts = agglomerated(transfer.coarse_starts, points, points if alone else RANK_POINTS)
        windows = Windows(rank, starts, transfer.lo, transfer.hi)
        # p on F and the indicator of A; from the grid itself K d on F, too
        steps.append(Step(transfer, starts, windows, 2 if steps else 3))
        if alone:
            break
    return steps, hierarchy


def traffic_of(steps: Sequence[Step], itemsize: int) -> tuple[int, int]:
    """Return what a rank sends in a sweep.

    Parameters
    ----------
    steps : list of Step
        Of that rank.
    itemsize : int
        Bytes of a number.

    Returns
    -------
    nbytes, messages : int
        In all.
    """
    nbytes, messages = np.sum([step.traffic for step in steps], axis=0)
    return int(nbytes) * itemsize, int(messages)


class Hierarchy:
    """What the sweep of a grid, body and precision needs besides memory for fields, made once.

    Parameters
    ----------
    grid : Grid
        The finest level.
    body : Body
        Its stiffness weights the levels.
    dtype : dtype
        Precision of the fields.
    coarsest_points : int, optional
        Levels of at most this many points are swept by rank 0 alone; default: COARSEST_POINTS.

    Attributes
    ----------
    steps, levels
        See `steps_of`.
    weights : array (levels,)
        Stiffness of each level, in the precision of the fields.
    softness : array (levels,)
        What each level adds to S, over S of the shortest wave.
    area : NominalArea
        The indicator of the nominal area on all levels.
    nominal : list of (array, array)
        Of every level that ranks share: what this indicator is a product of, on this rank's rows.
    gap_mode : GapMode
        Finds the deflation vector of a contact.
    """

    def __init__(self, grid: Grid, body: Body, dtype: np.dtype, coarsest_points: int | None = None):
        self.steps, self.levels = steps_of(grid, dtype, coarsest_points)
        # a single point has one weight for its two levels
        count = len(self.levels)
        self.softness = np.resize(body.softness(grid), count)
        self.weights = np.resize(body.weights(grid), count).astype(dtype)
        self.area = NominalArea(grid, self.levels, self.softness)
        starts = [grid.starts, *(step.starts for step in self.steps)]
        rank = grid.comm.rank
        self.nominal = [
            (x[rows[rank] : rows[rank + 1]].astype(dtype), y.astype(dtype))
            for (x, y), rows in zip(self.area.s, starts)
        ]
        alone = len(self.steps)
        self.gap_mode = GapMode(grid, body, self.levels[alone:], self.weights[alone:])
