"""What a search for a load knows of the heights before anything is solved."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from ..operators.problem import Problem

TIE = 64  # rounding errors of a height up to which two peaks are equally high


class HeightStatistics(NamedTuple):
    """Statistics of the heights of one grid.

    Attributes
    ----------
    points : int
        Number of points.
    highest : int
        Points as high as the highest peak, which touch at any load.
    indistinct : int
        Points that solutions in the working precision cannot tell from the highest peak, at least
        `highest`.
    top : float
        Mean gap where the highest peak just touches, over the unit of slopes.
    lowest : float
        Gap at the highest peak there, which is not 0 on a coarse grid that misses the peak.
    steepness : float
        rms slope between neighbours in a row.
    alone : float
        A mean pressure, in the program's unit, up to which a single highest point carries all; 0
        where several are as high.
    """

    points: int
    highest: int
    indistinct: int
    top: float
    lowest: float
    steepness: float
    alone: float

    @classmethod
    def of(cls, problem: Problem) -> HeightStatistics:
        """Measure the initial gap of a problem, which is stored.

        Collective.

        Returns
        -------
        HeightStatistics
            The same on all ranks.
        """
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
    """Return a mean pressure at which a single point carries all and has not gone down to the next
    one yet, which is `depth` below it.

    A mean pressure p0 presses the point down by N p0 S_00 relative to the mean of the surface. The
    next one may rise against that mean, but by less than S_00 over the points along the shorter
    axis. A point that yields carries no more than the hardness.

    Parameters
    ----------
    problem : Problem
        The contact; its load does not count.
    depth : float
        Height of the point above the next one, in the problem's unit; infinite without a next one.

    Returns
    -------
    float
        Mean pressure in the program's unit, 0 without a next point.
    """
    if not np.isfinite(depth):
        return 0.0
    grid = problem.grid
    rise = 1 / min(grid.n)
    carried = depth / (problem.body.point_compliance(grid) * (1 + rise))
    if problem.hardness is not None:
        carried = min(carried, problem.hardness)
    return carried / grid.N
