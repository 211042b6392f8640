"""What is asked at one load, in the program's own units: equations (1) and (2) in docs/method.md.

Units: in-plane length a = sqrt(a_x a_y), height g_rms a, pressure E* g_rms. Everything is then of
order one whatever the scene's units, and p0 is p*:

    p = p0 + K u    K(q) of the elastic body (|q|/2 for a half-space)
    g = u + h >= 0,    p >= 0,    p g = 0

With a hardness H the pressure is at most that, and where it is, the body has a dent of depth -g:

    0 <= p <= H,    p = 0 where g > 0,    p = H where g < 0

With an attraction phi(g) of the surfaces (laws/) p is the pressure of the wall,

    p = p0 + K u + t,    t = phi'(g),

so that the wall bears p0 + mean(t), the pressure of the body and what the attraction adds.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import inf

import numpy as np

from ..bodies.base import Body
from ..bodies.halfspace import HALF_SPACE
from ..laws.base import Law, in_precision
from ..parallel.fft import SlabFFT
from ..parallel.grid import Grid

Columns = Callable[[np.ndarray, int], None]  # changes block m of the columns of a spectrum

# rms of the error of K h over the rms of h, in units of the working precision: the largest seen
ROUNDING = 2.5
TRANSFORMED = 1.5  # of a transformed K u over the rms of u about its mean, likewise
SAMPLE = 16  # rows, at least, that say what the mean is


@dataclass(frozen=True)
class HeightSpectrum:
    """Heights known mode by mode; add(fft) returns what subtracts them from a block (block, m) of
    columns, in place; `dtype`: of the gap.
    """

    add: Callable[[SlabFFT], Columns]
    dtype: np.dtype


@dataclass(frozen=True)
class Problem:
    """A body pressed against a wall with a mean pressure.

    `h`: initial gap, minimum 0, this rank's nominal area; `p0`: mean pressure over that area;
    `hardness`: infinite for an elastic solid; `spring`: mean pressure of the cell per displacement,
    which changes p0 (0: a dead load); `h_rms`: sqrt(mean h^2), if known; `height_error`: of changed
    heights, the root of the sum of squares of K dh.
    """

    grid: Grid
    h: np.ndarray | HeightSpectrum
    p0: float
    h_rms: float | None = None
    body: Body = HALF_SPACE
    hardness: float = inf
    attraction: Law | None = None
    spring: float = 0.0
    height_error: float = 0.0

    def law(self, dtype: np.dtype | None = None) -> Law | None:
        """Return the law of attraction in a precision (default: the working one), or None."""
        if self.attraction is None:
            return None
        return in_precision(self.attraction, dtype or self.dtype)

    @property
    def yields(self) -> bool:
        """Whether there is a hardness."""
        return self.hardness < inf

    @property
    def limit(self) -> np.floating | None:
        """The hardness in the working precision, as kernels take it; None without one."""
        return self.dtype.type(self.hardness) if self.yields else None

    @property
    def dtype(self) -> np.dtype:
        """The working precision."""
        return self.h.dtype

    @cached_property
    def root_mean_square(self) -> float:
        """sqrt(mean h^2) over the surface, 0 if unknown. Collective at the first access."""
        if self.h_rms is not None or self.stored is None:
            return self.h_rms or 0.0
        h = self.stored
        grid = self.grid
        # rows: sums that long would lose digits
        squares = grid.by_rows(
            lambda i0, i1: np.einsum("ij,ij->i", h[i0:i1], h[i0:i1]).sum(dtype=float), len(h)
        )
        return float(np.sqrt(grid.comm.sum([sum(squares)])[0] / grid.N))

    @property
    def stored(self) -> np.ndarray | None:
        """Heights as an array, the local part of the nominal area; None for a HeightSpectrum."""
        return None if isinstance(self.h, HeightSpectrum) else self.h

    @property
    def heights(self) -> np.ndarray:
        """The heights as an array; AssertionError for a HeightSpectrum."""
        assert self.stored is not None
        return self.stored

    @property
    def p_cell(self) -> float:
        """The mean pressure over the whole grid."""
        return self.p0 * (self.grid.N / self.grid.cell_points)

    @cached_property
    def rounding(self) -> float:
        """Estimated rms pressure error by the precision of h and of the displacement beyond the
        surface (p_cell times the size of the cell). Collective at first access.
        """
        beyond = self.sunk if self.grid.padded else 0.0
        return (
            ROUNDING
            * float(np.finfo(self.dtype).eps)
            * float(np.hypot(self.root_mean_square, beyond))
        )

    @property
    def sunk(self) -> float:
        """Estimate of how much the displacement varies if only the load limits it, a height."""
        return float(self.p_cell * np.sqrt(self.grid.cell_points))

    def noise(self, h_rms: float) -> float:
        """Estimate the largest rms error of the pressure from transforms of this precision."""
        if self.stored is None:
            varies = h_rms
        else:
            varies = self.sunk if self.grid.padded else min(h_rms, self.sunk)
        return TRANSFORMED * float(np.finfo(self.dtype).eps) * varies

    def level(self, g: np.ndarray) -> float:
        """Estimate the mean of the field to transform, with which rounding grows. Collective."""
        every = max(1, len(g) // SAMPLE)
        few = g[::every]
        heights = 0.0 if self.stored is None else self.stored[::every].sum()
        total, points = self.grid.comm.sum([few.sum() - heights, few.size])
        return float(total / points)

    def transform_displacement(self, fft: SlabFFT, g: np.ndarray) -> float:
        """Transform u less about its mean, which is returned: g - h, g beyond the surface, or g
        where `adder` subtracts unstored heights. Collective.
        """
        from ..kernels.certify import displacement_passes

        level = self.level(g)
        h = np.zeros((0, 0), self.dtype) if self.stored is None else self.stored

        def transform(
            passes: np.ndarray, parts: np.ndarray, turns: np.ndarray, rows: tuple
        ) -> None:
            displacement_passes(passes, parts, turns, rows, g, h, level)

        fft.forward_passes(transform)
        return level

    def adder(self, fft: SlabFFT) -> Columns | None:
        """Return the function (block, m) that subtracts heights that are not stored, or None."""
        return self.h.add(fft) if isinstance(self.h, HeightSpectrum) else None


def self_energy(grid: Grid) -> float:
    """Return a bound of sqrt(<v, S v>), v = 1 on the nominal area less its mean, S of the half-
    space: by which mean gaps of surface and cell may differ.
    """
    # Of all shapes of equal area a disc has the largest <v, S v>, 0.958 area^(3/2). A strip of
    # width w in a cell of width W, periodic along its length, has (2/pi) (1/2 + ln(W/2w)) area w: S
    # is -(2/pi) ln|x| plus a constant, which v does not see. Points add up to 4 %.
    if not grid.padded:
        return 0.0
    free = [
        (m * s / grid.a, n / m) for m, n, s in zip(grid.nominal, grid.n, grid.spacings) if m != n
    ]
    longest = 0.0
    if len(free) == 1:
        ((width, cells),) = free
        longest = 1.04 * (2 / np.pi) * (0.5 + np.log(cells / 2)) * width
    return float(np.sqrt(grid.N * max(0.958 * np.sqrt(grid.N), longest)))
