"""S between two points of a surface, a table of their distances along x and y."""

from __future__ import annotations

import numpy as np
from numpy.typing import DTypeLike

from ..bodies.base import Body
from ..kernels import influence as kernels
from ..parallel.grid import Grid
from .elastic import Elastic


def influence(grid: Grid, body: Body, dtype: DTypeLike) -> np.ndarray:
    """Return S by the distances in points along x and y, up to a constant, on rank 0; an empty
    array on other ranks. Made with an FFT pair, and kept until another body needs one. Collective.
    """
    kept: dict[Body, np.ndarray] = grid.once((influence, np.dtype(dtype)), dict)
    if body not in kept:
        kept.clear()
        kept[body] = _influence(Elastic(grid, body, dtype))
    return kept[body]


def between(grid: Grid, S: np.ndarray, i: np.ndarray, j: np.ndarray) -> np.ndarray:
    """Return the matrix of S between points (i, j) of the surface, from the table of `influence`.
    Not collective.
    """
    matrix = np.empty((len(i), len(i)))
    kernels.between(S, grid.n, i, j, matrix)
    return matrix


def _influence(elastic: Elastic) -> np.ndarray:
    """Press the first point of the surface with 1."""
    grid = elastic.grid
    rows, columns = (m if m < n else n // 2 + 1 for m, n in zip(grid.nominal, grid.n))
    start, stop = np.minimum(grid.rows, rows)
    moved = np.empty((stop - start, columns), elastic.dtype)

    def press(i0: int, i1: int, x: np.ndarray) -> None:
        x[: i1 - i0] = 0
        if grid.rows[0] + i0 == 0:
            x[0, 0] = 1

    def take(i0: int, i1: int, u: np.ndarray) -> None:
        count = max(min(i1, len(moved)) - i0, 0)
        moved[i0 : i0 + count] = u[:count, :columns]

    elastic.pressure_rows(press)
    elastic.columns(inverse=True)
    elastic.use_rows(take)
    parts = grid.comm.gather(moved)
    return np.concatenate(parts).astype(np.float64) if parts else np.empty((0, 0))
