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
    """Linear elastic, infinitely deep, periodic in the plane."""

    name = "halfspace"
    table_share = 0.0

    @classmethod
    def of(cls, material: Material, free: Sequence[bool]) -> Body | None:
        """Return the half-space, where a scene has no thickness and its surface is periodic.

        Parameters
        ----------
        material : scene.Material
            Lengths in the unit of the surface's.
        free : pair of bool
            Whether the surface ends along x, along y.

        Returns
        -------
        HalfSpace or None
            None of layers, and of a surface that ends.
        """
        return HALF_SPACE if material.thickness is None and not any(free) else None

    def stiffness(self, q: np.ndarray, a: float) -> np.ndarray:
        """Return the stiffness K = |q|/2 of the half-space.

        Parameters
        ----------
        q : array
            Wave numbers >= 0, in units of 1/a.
        a : float
            Grid spacing; a half-space has no length of its own, so it does not count.

        Returns
        -------
        array
            K in units of 1/a, in the shape of q.
        """
        return q / 2

    def make_multipliers(self, grid: Grid, fft: SlabFFT, q: Waves) -> Multipliers:
        """Make the Multipliers without a table: |q|/2 is computed as it is needed.

        Parameters
        ----------
        grid : Grid
            The grid.
        fft : SlabFFT
            Its transforms in one precision; the Multipliers do not hold it.
        q : (q_x, q_y)
            Wave numbers (n_x,) and (blocks of this rank, W), in 1/a.

        Returns
        -------
        Multipliers
            Of |q|/2.
        """
        return Multipliers(grid, fft, q)


HALF_SPACE = HalfSpace()
