"""What a search for a load has to know of the heights of a grid."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from ..parallel.grid import Grid


TIE = 64.0  # times the rounding error of heights: as high


class Wall(NamedTuple):
    """points: of the surface; highest: those as high as the highest peak, which touch at any load;
    top: mean gap where it just touches, over the unit of slopes; steepness: rms slope between
    neighbours in a row, in that unit; lowest: gap at that peak, which on coarse grids is not that
    of the surface, as top."""

    points: int
    highest: int
    top: float
    steepness: float
    lowest: float

    @classmethod
    def of(cls, grid: Grid, h: np.ndarray) -> Wall:
        """h: this rank's slab, in the problem's unit. Collective."""
        lowest = -grid.comm.max([-float(h.min(initial=np.inf))])[0]
        squares = sum(float(np.square(row[1:] - row[:-1]).sum(dtype=float)) for row in h)
        total, squares = grid.comm.sum([h.sum(dtype=float), squares])
        tie = TIE * float(np.finfo(h.dtype).eps) * (total / grid.N - lowest)
        highest = grid.comm.sum([np.count_nonzero(h <= lowest + tie)])[0]
        steepness = np.sqrt(squares / grid.N) * grid.a / grid.spacings[1]
        return cls(
            grid.N,
            int(highest),
            float(total / grid.N - lowest) * grid.a,
            float(steepness),
            float(lowest) * grid.a,
        )
