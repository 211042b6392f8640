"""What a search for a load knows of the heights before anything is solved."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from ..parallel.grid import Grid

TIE = 64  # rounding errors of a height up to which two peaks are equally high


class HeightStatistics(NamedTuple):
    """Statistics of the heights of one grid.

    Attributes
    ----------
    points : int
        Number of points.
    highest : int
        Points as high as the highest peak, which touch at any load.
    top : float
        Mean gap where the highest peak just touches, over the unit of slopes.
    lowest : float
        Gap at the highest peak there, which is not 0 on a coarse grid that misses the peak.
    steepness : float
        rms slope between neighbours in a row.
    """

    points: int
    highest: int
    top: float
    lowest: float
    steepness: float

    @classmethod
    def of(cls, grid: Grid, h: np.ndarray) -> HeightStatistics:
        """Measure the initial gap h.

        Collective.

        Parameters
        ----------
        grid : Grid
            The grid of the heights.
        h : ndarray
            Initial gap, local slab of the nominal area, in the problem's unit of height.

        Returns
        -------
        HeightStatistics
            The same on all ranks.
        """
        lowest = grid.comm.min([float(h.min(initial=np.inf))])[0]
        squares = sum(float(np.square(row[1:] - row[:-1]).sum(dtype=float)) for row in h)
        total, squares = grid.comm.sum([h.sum(dtype=float), squares])
        top = float(total / grid.N - lowest)
        is_highest = h <= lowest + TIE * float(np.finfo(h.dtype).eps) * top
        highest = int(grid.comm.sum([np.count_nonzero(is_highest)])[0])
        steepness = float(np.sqrt(squares / grid.N) * grid.a / grid.spacings[1])
        return cls(grid.N, highest, top * grid.a, float(lowest) * grid.a, steepness)
