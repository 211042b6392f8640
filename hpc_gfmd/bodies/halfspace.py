"""The elastic half-space, K = |q|/2, computed on the fly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

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
        def make() -> Multipliers:
            q_y = grid.column_tables(fft)[0][grid.comm.rank :: grid.comm.size]
            return Multipliers(grid, fft, self.waves(grid, grid.q_x, q_y))

        return self.kept(fft, make)


HALF_SPACE = HalfSpace()
