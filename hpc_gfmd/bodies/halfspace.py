"""The elastic half-space, K = |q|/2, computed on the fly."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..parallel.fft import SlabFFT
from ..parallel.grid import Grid
from ..scene import Material
from .base import Body, Multipliers, Waves


@dataclass(frozen=True)
class HalfSpace(Body):
    """A linear elastic, infinitely deep body under a surface that is periodic along both axes."""

    name = "halfspace"
    table_share = 0.0

    @classmethod
    def of(cls, material: Material, free: Sequence[bool]) -> Body | None:
        """Return the half-space, for a scene without a thickness and free boundaries."""
        return HALF_SPACE if material.thickness is None and not any(free) else None

    def stiffness(self, q: np.ndarray, a: float) -> np.ndarray:
        return q / 2

    def make_multipliers(self, grid: Grid, fft: SlabFFT, q: Waves) -> Multipliers:
        """Make the Multipliers without a table: |q|/2 is computed on the fly. Not collective."""
        return Multipliers(grid, fft, q)


HALF_SPACE = HalfSpace()
