"""Statistics of the heights that the search for a prescribed area, gap or approach uses.

They tell before anything is solved how many points touch at any load, which mean gap there is at
touch, and up to which load the highest point carries it alone.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from ..operators.problem import Problem

TIE = 64  # factor on rounding errors: a smaller difference of two heights counts as none


class HeightStatistics(NamedTuple):
    """Statistics of the heights of one grid; lengths are over the unit of slopes."""

    points: int  # of the surface
    highest: int  # points as high as the highest one; they touch at any load
    indistinct: int  # points that the working precision cannot distinguish from the highest one
    top: float  # mean of the initial gap above that of the highest point
    # initial gap of the highest point: 0, unless a coarse grid lacks the highest peak
    lowest: float
    steepness: float  # rms slope between neighbours in a row
    # Mean pressure, program's unit, up to which the highest point certainly carries the load alone;
    # 0 if several points are as high.
    alone: float

    @classmethod
    def of(cls, problem: Problem) -> HeightStatistics:
        """Measure the initial gap of a problem, whose heights must be stored. Collective."""
        grid = problem.grid
        h = problem.heights
        lowest = float(grid.comm.min([float(h.min(initial=np.inf))])[0])
        squares = sum(float(np.square(row[1:] - row[:-1]).sum(dtype=float)) for row in h)
        total, squares = grid.comm.sum([h.sum(dtype=float), squares])
        top = float(total / grid.N - lowest)
        # next to the peak gaps are small, and as accurate in single precision
        equal = lowest + TIE * float(np.finfo(np.float64).eps) * top
        indistinct = lowest + TIE * float(np.finfo(h.dtype).eps) * top
        counts = [np.count_nonzero(h <= equal), np.count_nonzero(h <= indistinct)]
        next_gap = grid.comm.min([float(h.min(initial=np.inf, where=h > equal))])[0]
        highest, close = (int(count) for count in grid.comm.sum(counts))
        alone = carried_alone(problem, float(next_gap) - lowest) if highest == 1 else 0.0
        steepness = float(np.sqrt(squares / grid.N) * grid.a / grid.spacings[1])
        return cls(grid.N, highest, close, top * grid.a, lowest * grid.a, steepness, alone)


def carried_alone(problem: Problem, depth: float) -> float:
    """Return a mean pressure that the highest point certainly carries alone, if the next is `depth`
    lower.

    p0 presses the point down by N p0 S_00 relative to the mean of the surface, above which the next
    one rises by less than that over the points along the shorter axis. With a hardness half of the
    load at which the point yields counts.
    """
    if not np.isfinite(depth):
        return 0.0
    grid = problem.grid
    rise = 1 / min(grid.n)
    carried = depth / (problem.body.point_compliance(grid) * (1 + rise))
    return min(carried, 0.5 * problem.hardness) / grid.N
