"""What a rank has and sends: worked out by the code that runs, for any rank of any number of ranks,
without memory and messages."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import DTypeLike

from ..bodies.free import Free
from ..driver.nested import Decimation
from ..kernels.bpx import UpdateSums
from ..operators.hierarchy import Step, steps_of, traffic_of
from ..parallel.coarsening import Level
from ..parallel.comm import DryRunComm, stages
from ..parallel.grid import Grid
from ..parallel.layout import Layout

# numbers that a step of bpx sums over all ranks, the last with those of a sweep
REDUCTIONS = 2, 2, len(UpdateSums._fields) + 8


@dataclass(frozen=True)
class Share:
    """What one rank has of a grid; dtype: of the fields. With nested=False there are no coarser
    grids to be solved on."""

    grid: Grid
    dtype: np.dtype
    nested: bool = True

    @property
    def points(self) -> int:
        """Points of its slab."""
        return math.prod(self.grid.shape)

    @cached_property
    def layout(self) -> Layout:
        """Rows and columns of the transforms of the finest grid."""
        return self.layout_of(self.grid, self.dtype)

    @staticmethod
    def layout_of(grid: Grid, dtype: DTypeLike) -> Layout:
        """Work out the layout of any grid."""
        return Layout(
            grid.n, grid.starts, grid.comm.rank, 2 * np.dtype(dtype).itemsize, grid.comm.node_ranks
        )

    @cached_property
    def grids(self) -> list[Grid]:
        """The coarser grids of a nested iteration that this rank has a part in, finest first."""
        found: list[Grid] = []
        grid = self.grid
        while self.nested and (step := Decimation.of(grid)) is not None and step.coarse is not None:
            grid = step.coarse
            found.append(grid)
        return found

    @cached_property
    def hierarchy(self) -> tuple[list[Step], list[Level]]:
        """The steps of the preconditioner that are distributed, and the first one that is not; all
        of its levels."""
        return steps_of(self.grid, self.dtype)

    def _points_alone(self, first: int) -> int:
        """Count the points of the levels from this one on, which rank 0 has alone."""
        levels = self.hierarchy[1][first:] if self.grid.comm.rank == 0 else ()
        return sum(math.prod(level.n) for level in levels)

    @property
    def level_points(self) -> int:
        """Points of all coarse levels of the preconditioner, halo rows not counted."""
        steps, _ = self.hierarchy
        shared = sum(step.owned * step.transfer.m[1] for step in steps)
        return shared + self._points_alone(len(steps) + 1)

    @property
    def level_bytes(self) -> int:
        """What the preconditioner holds, windows counted, too."""
        steps, _ = self.hierarchy
        numbers = sum(math.prod(step.window_shape) for step in steps)
        numbers += sum(math.prod(step.owned_shape) for step in steps[:-1] if not step.in_place)
        return (numbers + 2 * self._points_alone(len(steps))) * self.dtype.itemsize

    @property
    def nested_points(self) -> int:
        """Points of all coarser grids that it has a part in."""
        return sum(math.prod(grid.shape) for grid in self.grids)

    @property
    def coarse_points(self) -> int:
        """Points of the coarse levels, or of the coarser grids, whichever are more."""
        return max(self.level_points, self.nested_points)

    @cached_property
    def level_traffic(self) -> tuple[int, int]:
        """(bytes, messages) that it sends in a sweep over the levels."""
        return traffic_of(self.hierarchy[0], self.dtype.itemsize)

    @property
    def reduction_traffic(self) -> tuple[int, int]:
        """(bytes, messages) that it sends in the reductions of an iteration."""
        depth, numbers = stages(self.grid.comm.size), list(REDUCTIONS)
        if self.grid.padded:
            (m_x, m_y), (n_x, n_y) = self.grid.nominal, self.grid.n
            numbers.append(Free((m_x != n_x, m_y != n_y)).exchanged(self.grid))
        return 8 * sum(numbers) * depth, len(numbers) * depth

    @property
    def traffic(self) -> tuple[int, int]:
        """(bytes, messages) that it sends in an iteration of bpx: one FFT pair."""
        nbytes, messages = zip(self.layout.traffic(), self.level_traffic, self.reduction_traffic)
        return sum(nbytes), sum(messages)

    @property
    def padding(self) -> float:
        """Columns that all ranks hold over those of the half spectrum."""
        return float(self.layout.columns_held.sum() / self.layout.n_c)


def share_of(
    n: Sequence[int],
    dtype: DTypeLike,
    ranks: int,
    rank: int = 0,
    nominal: Sequence[int] | None = None,
    nested: bool = True,
    per_node: int = 1,
) -> Share:
    """Work out the Share of one rank of a grid of n points; nominal: those of the surface;
    per_node: ranks on each node, dealt out in their order, which need no messages to transpose
    among themselves."""
    comm: Any = DryRunComm(rank, ranks, np.arange(ranks) // per_node)
    return Share(Grid(n, (1.0, 1.0), comm, nominal=nominal), np.dtype(dtype), nested)


def busiest(
    n: Sequence[int], dtype: DTypeLike, ranks: int, per_node: int = 1, **how: Any
) -> list[Share]:
    """List the Shares of ranks among which is the one with most of everything: rank 0 has a part in
    all levels, and all remainders; ranks of the last node, which may be fewer, send more."""
    chosen = {0, min(1, ranks - 1), ranks // 2, (ranks - 1) // per_node * per_node, ranks - 1}
    return [share_of(n, dtype, ranks, rank, per_node=per_node, **how) for rank in sorted(chosen)]
