"""What a search for a load has to know of the heights of a grid."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from ..grid import Grid


class Wall(NamedTuple):
    """points: of the surface; top: mean gap where the highest peak just touches, over the unit of slopes; steepness: rms slope between
    neighbours in a row, in that unit; lowest: gap at that peak, which on coarse grids is not that of the surface, as top."""

    points: int
    top: float
    steepness: float
    lowest: float

    @classmethod
    def of(cls, grid: Grid, h: np.ndarray) -> Wall:
        """h: this rank's slab, in the problem's unit. Collective."""
        lowest = -grid.comm.max([-float(h.min(initial=np.inf))])[0]
        squares = sum(float(np.square(row[1:] - row[:-1]).sum(dtype=float)) for row in h)
        total, squares = grid.comm.sum([h.sum(dtype=float), squares])
        steepness = np.sqrt(squares / grid.N) * grid.a / grid.spacings[1]
        return cls(grid.N, float(total / grid.N - lowest) * grid.a, float(steepness), float(lowest) * grid.a)
