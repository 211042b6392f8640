"""Memory and messages of a rank, for any rank of any number of ranks: computed from the tables of
the package, without allocating memory or sending messages."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hpc_gfmd.bodies.free import Free
from hpc_gfmd.driver.decimation import Decimation
from hpc_gfmd.kernels.bpx import UpdateSums
from hpc_gfmd.operators.hierarchy import steps_of
from hpc_gfmd.parallel.grid import Grid
from hpc_gfmd.parallel.layout import Layout

# numbers in each sum over all ranks of a step of bpx; the last includes those of a sweep
REDUCTIONS = 4, 2, len(UpdateSums._fields) + 8


class DryRunComm:
    """The communicator of an imagined rank: knows who is where, but cannot send."""

    mpi = parent = None

    def __init__(self, rank, size, nodes):
        self.rank = rank
        self.size = size
        self._nodes = nodes

    @property
    def node_ranks(self):
        """The ranks on the same node, ascending."""
        return np.flatnonzero(self._nodes == self._nodes[self.rank])

    def subcomm(self, ranks):
        """Return the communicator of these ranks alone; None if this rank is not among them."""
        if self.rank not in ranks:
            return None
        return DryRunComm(ranks.index(self.rank), len(ranks), self._nodes[ranks])


@dataclass(frozen=True)
class Share:
    """One rank's share of a grid: its points, levels and messages.

    Attributes
    ----------
    grid : Grid
        The grid as this rank sees it.
    dtype : dtype
        Type of the fields.
    """

    grid: Grid
    dtype: np.dtype

    @property
    def points(self):
        """Number of points in the slab of this rank."""
        return math.prod(self.grid.shape)

    @cached_property
    def layout(self):
        """Rows and columns of the transforms of the grid: which rank has which."""
        grid = self.grid
        itemsize = 2 * self.dtype.itemsize
        return Layout(grid.n, grid.starts, grid.comm.rank, itemsize, grid.comm.node_ranks)

    @cached_property
    def grids(self):
        """Coarser grids of a nested iteration on which this rank has points, finest first."""
        coarser = []
        grid = self.grid
        while (step := Decimation.of(grid)) is not None and step.coarse is not None:
            grid = step.coarse
            coarser.append(grid)
        return coarser

    @cached_property
    def hierarchy(self):
        """(steps, levels) of the preconditioner.

        The steps are those to the distributed levels and the first one to a level that is not
        distributed. The levels are all of them, the grid itself first.
        """
        return steps_of(self.grid, self.dtype)

    @property
    def _points_alone(self):
        """Number of points of the coarse levels that are not distributed; 0 if not on this rank."""
        steps, every_level = self.hierarchy
        levels = every_level[len(steps) :] if self.grid.comm.rank in steps[-1].ranks else ()
        return sum(math.prod(level.n) for level in levels)

    @property
    def level_points(self):
        """Number of points of all coarse levels of the preconditioner on this rank."""
        steps, _ = self.hierarchy
        return sum(step.owned * step.transfer.m[1] for step in steps[:-1]) + self._points_alone

    @property
    def level_bytes(self):
        """Bytes of the levels of the preconditioner on this rank."""
        steps, _ = self.hierarchy
        numbers = sum(math.prod(step.window_shape) for step in steps[:-1])
        last = steps[-1]
        if self.grid.comm.size > 1:  # one process has the last window where the whole level is
            numbers += math.prod(last.window_shape)
        numbers += (last.fields - 2) * math.prod(last.transfer.m)
        numbers += sum(math.prod(step.owned_shape) for step in steps[:-1] if step.windows)
        return (numbers + 2 * self._points_alone) * self.dtype.itemsize

    @property
    def nested_points(self):
        """Number of points of all coarser grids of the nested iteration on this rank."""
        return sum(math.prod(grid.shape) for grid in self.grids)

    @property
    def coarse_points(self):
        """Number of points of the coarse levels, or of the coarser grids, whichever is larger."""
        return max(self.level_points, self.nested_points)

    @cached_property
    def level_traffic(self):
        """(bytes, messages) that this rank sends in one sweep over the levels."""
        return traffic_of(self.hierarchy[0], self.dtype.itemsize)

    @property
    def reduction_traffic(self):
        """(bytes, messages) that this rank sends in the sums over ranks of one iteration."""
        depth = stages(self.grid.comm.size)
        numbers = list(REDUCTIONS)
        if self.grid.padded:
            (m_x, m_y), (n_x, n_y) = self.grid.nominal, self.grid.n
            numbers.append(Free((m_x != n_x, m_y != n_y)).exchanged(self.grid))
        return 8 * sum(numbers) * depth, len(numbers) * depth

    @property
    def traffic(self):
        """(bytes, messages) that this rank sends in one iteration of bpx, which is one FFT pair."""
        parts = transpose_traffic(self.layout), self.level_traffic, self.reduction_traffic
        nbytes, messages = zip(*parts)
        return sum(nbytes), sum(messages)


def share_of(n, dtype, ranks, rank=0, per_node=1):
    """Return the share that one rank has of a grid of n points.

    per_node: ranks on each node, assigned in their order; they transpose without messages among
    themselves.
    """
    comm = DryRunComm(rank, ranks, np.arange(ranks) // per_node)
    return Share(Grid(n, tuple(map(float, n)), comm), np.dtype(dtype))


def busiest(n, dtype, ranks, per_node=1):
    """Return the shares of a few ranks, among which are the largest in every respect.

    Rank 0 has a part in all levels and all remainders. The ranks of the last node, which may be
    fewer than on others, send more.
    """
    chosen = {0, min(1, ranks - 1), ranks // 2, (ranks - 1) // per_node * per_node, ranks - 1}
    return [share_of(n, dtype, ranks, rank, per_node) for rank in sorted(chosen)]


def groups_of(steps):
    """Split the steps into groups within which a rank restricts without waiting for messages.

    A group ends with a step whose coarse rows are gathered, the last one with the step to the first
    level that a rank has alone.
    """
    groups = [[]]
    for step in steps:
        groups[-1].append(step)
        if step.windows is not None:
            groups.append([])
    return groups


def stages(size):
    """Return the messages a rank sends in a reduction, by recursive doubling."""
    return (size - 1).bit_length()


def rows_by_rank(pieces):
    """Return how many rows go to each rank, or come from it."""
    return {
        peer: sum(rows.stop - rows.start for rows in of_peer) for peer, of_peer in pieces.items()
    }


def transpose_traffic(layout):
    """Return (bytes, messages) that a rank sends to other nodes in one FFT pair."""
    to_others = layout.block_widths[:, layout.far]
    mine = layout.block_widths[:, layout.rank]
    rows = np.diff(layout.starts) * layout.far
    nbytes = (layout.n_loc * to_others.sum() + rows.sum() * mine.sum()) * layout.itemsize
    messages_forward = np.count_nonzero(to_others) * (layout.n_loc > 0)
    messages_back = np.count_nonzero(mine) * np.count_nonzero(rows)
    return int(nbytes), int(messages_forward + messages_back)


def traffic_of(steps, itemsize):
    """Return the bytes and the messages that a rank sends in one sweep by its steps."""
    numbers = messages = 0
    for group in groups_of(steps):
        peers = set()
        for step in group[:-1]:
            sent = rows_by_rank(step.overlaps.give)
            numbers += step.fields * sum(sent.values()) * step.transfer.m[1]
            peers |= set(sent)
        messages += len(peers)
        windows = group[-1].windows
        if windows is not None:
            down = rows_by_rank(windows.take)
            up = rows_by_rank(windows.give)
            rows = group[-1].fields * sum(down.values()) + sum(up.values())
            numbers += rows * group[-1].transfer.m[1]
            messages += len(down) + len(up)
    last = steps[-1]
    if len(last.ranks) > 1 and last.transfer.rank in last.ranks:
        rounds = stages(len(last.ranks))
        numbers += rounds * last.fields * last.window_rows * last.transfer.m[1]
        messages += rounds
    return numbers * itemsize, messages
