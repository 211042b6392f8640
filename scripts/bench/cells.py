"""The half-space with free edges as most codes discretise it: a pressure that is constant on the
cell around each grid point.

Love's solution for the displacement in the middle of one cell by the pressure on another, in place
of the band-limited Green's function of bodies/free.py. For comparisons on equal terms only, on one
rank, with both axes free.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hpc_gfmd.bodies.base import Multipliers, Tabled
from hpc_gfmd.bodies.free import Coupled, Free, added
from hpc_gfmd.bodies.images import images, kernel
from hpc_gfmd.parallel.fft import SlabFFT
from hpc_gfmd.parallel.grid import Grid


@dataclass(frozen=True)
class Cells(Free):
    """See bodies/free.py: nothing but S between two points is different."""

    def _coupled(self, plain: Multipliers, grid: Grid, fft: SlabFFT) -> Multipliers:
        shape = self._shape(grid)
        if shape is None:
            return plain
        tabled = Tabled(grid, fft, self.table(grid, fft))
        found, length = images(*shape[:-1]), np.sqrt(np.prod(grid.sizes)) / grid.a
        modes = (
            tabled.table.reshape(-1, tabled.table.shape[-1])[
                : found.modes[1] + 1, : found.modes[0] + 1
            ].T
            * length
        )
        S = np.divide(1, modes, out=np.zeros(modes.shape), where=modes > 0)
        return Coupled(tabled, grid, fft, found, added(found, S, fft.dtype))

    def table(self, grid: Grid, fft: SlabFFT) -> np.ndarray:
        """K of the periodic cell: S less what `Coupled` adds to it."""
        out = np.zeros((fft.K, fft.W, grid.n[0] // 2 + 1), fft.dtype)
        cell = [k * s / grid.a for k, s in zip(grid.n, grid.spacings)]

        def rows(i0: int, i1: int, x: np.ndarray) -> None:
            self.compliance_rows(grid)(i0, i1, x)
            x[: i1 - i0] -= kernel(*offsets(grid, i0, i1), *cell)

        def keep(block: np.ndarray, m: int) -> None:
            out[m, : len(block)] = 1 / block.real[:, : grid.n[0] // 2 + 1]

        fft.forward_rows(rows)
        fft.columns(keep, backward=False)
        return out

    def compliance_rows(self, grid: Grid) -> Callable[[int, int, np.ndarray], None]:
        """fill(i0, i1, x): rows of S between point 0 and all others."""
        half = [s / grid.a / 2 for s in grid.spacings]

        def fill(i0: int, i1: int, out: np.ndarray) -> None:
            x, y = offsets(grid, i0, i1)
            out[: i1 - i0] = sum(
                sx * sy * _corner(x[:, None] + sx * half[0], y + sy * half[1])
                for sx in (1, -1)
                for sy in (1, -1)
            )
            out[: i1 - i0] /= np.pi

        return fill


def offsets(grid: Grid, i0: int, i1: int) -> tuple[np.ndarray, np.ndarray]:
    """Distances along both axes of the points of some rows from point 0 or its nearest image, in
    units of a."""
    points = np.arange(i0, i1), np.arange(grid.n[1])
    x, y = (np.minimum(i, n - i) * (s / grid.a) for i, n, s in zip(points, grid.n, grid.spacings))
    return x, y


def _corner(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Integral of 1/r over the rectangle between the origin and (x, y)."""
    return x * np.arcsinh(y / np.abs(x)) + y * np.arcsinh(x / np.abs(y))
