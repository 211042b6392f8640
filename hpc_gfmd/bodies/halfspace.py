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
        """Return the half-space, if a scene has no thickness and periodic boundaries.

        Parameters
        ----------
        material : scene.Material
            Lengths in the unit of the surface's.
        free : pair of bool
            Whether the boundaries along x, along y are free instead of periodic.

        Returns
        -------
        HalfSpace or None
            None if the material has a thickness, or a boundary is free.
        """
        return HALF_SPACE if material.thickness is None and not any(free) else None

    def stiffness(self, q: np.ndarray, a: float) -> np.ndarray:
        """Return the stiffness K = |q|/2 of the half-space.

        Parameters
        ----------
        q : array
            Wave numbers >= 0, in units of 1/a.
        a : float
            Not used: a half-space has no length of its own.

        Returns
        -------
        array
            K in units of 1/a, in the shape of q.
        """
        return q / 2

    def make_multipliers(self, grid: Grid, fft: SlabFFT, q: Waves) -> Multipliers:
        """Make the Multipliers without a table: |q|/2 is computed as it is needed. Not collective.

        Parameters
        ----------
        grid : Grid
            The grid.
        fft : SlabFFT
            Its transforms in one precision; the Multipliers keep no reference to it.
        q : (q_x, q_y)
            Wave numbers (n_x,) and (blocks of this rank, W), in 1/a.

        Returns
        -------
        Multipliers
            Of |q|/2.
        """
        return Multipliers(grid, fft, q)


HALF_SPACE = HalfSpace()
