"""The elastic half-space, K = |q|/2, computed on the fly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..kernels.spectral import multiply_compliance, multiply_stiffness
from .base import Body, Multipliers

if TYPE_CHECKING:
    from ..parallel.fft import SlabFFT
    from ..parallel.grid import Grid
    from ..scene import Material


@dataclass(frozen=True)
class HalfSpace(Body):
    """Linear elastic, infinitely deep, periodic in the plane."""

    name = "halfspace"
    table_share = 0.0

    @classmethod
    def of(cls, material: Material, free: Sequence[bool]) -> Body | None:
        return HALF_SPACE if material.thickness is None and not any(free) else None

    def stiffness(self, q: np.ndarray, a: float) -> np.ndarray:
        return q / 2

    def multipliers(self, grid: Grid, fft: SlabFFT) -> Multipliers:
        q_y, weight = grid.column_tables(fft)
        return OnTheFly(fft, *self.waves(grid, grid.q_x, q_y), weight)


HALF_SPACE = HalfSpace()


class OnTheFly(Multipliers):
    """Multiplies by K = |q|/2 and S = 2/|q| without a table. q_x: (n_x,); q_y, weight: as
    Grid.column_tables."""

    def __init__(self, fft: SlabFFT, q_x: np.ndarray, q_y: np.ndarray, weight: np.ndarray):
        self.dtype, self.scale = fft.dtype, fft.scale
        # kernels see real and imaginary parts as numbers of their own
        self.q_x = np.repeat(q_x, 2).astype(fft.dtype)
        self.q_y, self.weight = q_y.astype(fft.dtype), weight

    def stiffness(self, block: np.ndarray, m: int) -> float:
        return self._call(multiply_stiffness, block, m, 0.5)

    def compliance(self, block: np.ndarray, m: int) -> float:
        return self._call(multiply_compliance, block, m, 2.0)

    def _call(self, kernel: Any, block: np.ndarray, m: int, factor: float) -> float:
        return kernel(
            block.view(self.dtype),
            self.q_x,
            self.q_y[m],
            self.weight[m],
            self.dtype.type(factor * self.scale),
        )
