"""What is asked at one load, in the program's own units.

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

import numpy as np

from ..bodies.base import Body
from ..bodies.halfspace import HALF_SPACE
from ..laws.base import Law, in_precision
from ..parallel.fft import SlabFFT
from ..parallel.grid import Grid

Rows = Callable[[int, int, np.ndarray], None]  # makes rows i0..i1 of a field in x
Columns = Callable[[np.ndarray, int], None]  # changes block m of the columns of a spectrum

# rms of the error of K h over the rms of h, in units of the working precision: the largest seen
ROUNDING = 2.5
TRANSFORMED = 1.5  # of a transformed K u over the rms of u about its mean, likewise
SAMPLE = 64  # rows, at least, that say what the mean is


@dataclass(frozen=True)
class HeightSpectrum:
    """Heights that are not stored but known mode by mode.

    Attributes
    ----------
    add : function
        add(fft) returns a function of (block, m) that adds the transform of minus the heights to
        a block of columns.
    dtype : dtype
        Precision of the gap.
    """

    add: Callable[[SlabFFT], Columns]
    dtype: np.dtype


@dataclass(frozen=True)
class Problem:
    """A body pressed against a wall with a mean pressure.

    Attributes
    ----------
    grid : Grid
        Of the cell.
    h : array, local part of the nominal area, or HeightSpectrum
        Initial gap, >= 0 with minimum 0, in the working precision.
    p0 : float
        Mean pressure over the nominal area.
    h_rms : float
        What root_mean_square was, where that is known.
    body : Body
        See bodies/.
    hardness : float or None
        The largest pressure; None: there is none.
    attraction : Law or None
        Law of attraction in the program's units; None: there is none.
    spring : float
        Stiffness, mean pressure of the cell per displacement, of the spring through which the body
        is pressed; 0: a dead load. With a spring p0 changes with every step.
    """

    grid: Grid
    h: np.ndarray | HeightSpectrum
    p0: float
    h_rms: float | None = None
    body: Body = HALF_SPACE
    hardness: float | None = None
    attraction: Law | None = None
    spring: float = 0.0

    def law(self, dtype: np.dtype | None = None) -> Law | None:
        """Return the law of attraction as kernels take it, in a precision (the working one)."""
        if self.attraction is None:
            return None
        return in_precision(self.attraction, dtype or self.dtype)

    @property
    def limit(self) -> np.floating | None:
        """The hardness as kernels take it."""
        return None if self.hardness is None else self.dtype.type(self.hardness)

    @property
    def dtype(self) -> np.dtype:
        """The working precision."""
        return self.h.dtype

    @cached_property
    def root_mean_square(self) -> float:
        """sqrt(mean h^2). Collective where it is first asked for."""
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
        """The heights, where they are stored."""
        return None if isinstance(self.h, HeightSpectrum) else self.h

    @property
    def heights(self) -> np.ndarray:
        """The heights, which are stored."""
        assert self.stored is not None
        return self.stored

    @property
    def p_cell(self) -> float:
        """The mean pressure over the whole grid."""
        return self.p0 * (self.grid.N / self.grid.cell_points)

    @cached_property
    def rounding(self) -> float:
        """The rms error of the pressure that comes from storing h in the working precision, and the
        displacement beyond the surface, which is of the order of p_cell times the size of the cell.
        Collective."""
        beyond = self.sunk if self.grid.padded else 0.0
        return (
            ROUNDING
            * float(np.finfo(self.dtype).eps)
            * float(np.hypot(self.root_mean_square, beyond))
        )

    @property
    def sunk(self) -> float:
        """How much the displacement varies where nothing but the load limits it, about."""
        return float(self.p_cell * np.sqrt(self.grid.cell_points))

    def noise(self, h_rms: float) -> float:
        """Return the rms error of the pressure from transforms in the working precision, at most;
        h_rms: of the heights."""
        if self.stored is None:
            varies = h_rms
        else:
            varies = self.sunk if self.grid.padded else min(h_rms, self.sunk)
        return TRANSFORMED * float(np.finfo(self.dtype).eps) * varies

    def level(self, g: np.ndarray) -> float:
        """Return about the mean of what is transformed of u = g - h. K does not see it, but
        rounding errors go with it. Collective."""
        every = max(1, len(g) // SAMPLE)
        few = g[::every]
        heights = 0.0 if self.stored is None else self.stored[::every].sum()
        total, points = self.grid.comm.sum([few.sum() - heights, few.size])
        return float(total / points)

    def displacement_rows(self, g: np.ndarray, level: float) -> Rows:
        """Return a function that makes rows of the displacement for a transform.

        Parameters
        ----------
        g : array, local slab
            Gap, or displacement beyond the surface.
        level : float
            A constant that is taken off, about the mean: see `level`.

        Returns
        -------
        function
            fill(i0, i1, x) sets x to rows of u - level, u = g - h (g itself beyond the surface), or
            of g where `adder` does the rest; x may be of another precision.
        """
        from ..kernels.certify import displacement_rows

        h = np.zeros((0, 0), self.dtype) if self.stored is None else self.stored
        return lambda i0, i1, x: displacement_rows(g, h, x, i0, i1, level)

    def adder(self, fft: SlabFFT) -> Columns | None:
        """Return what completes the columns of u after a transform of its rows: None where the rows
        are those of u already."""
        return self.h.add(fft) if isinstance(self.h, HeightSpectrum) else None


def self_energy(grid: Grid) -> float:
    """Return an upper bound of sqrt(<v, S v>), S = 1/K, where v is 1 on the nominal area and 0
    in the padding, minus its mean; 0 on a grid without padding.

    It bounds how much the mean gap over the surface may differ from that over the cell.

    Of all shapes of equal area a disc has the largest <v, S v>, 0.958 area^(3/2). A strip, periodic
    along its length, has (4/pi^3) 1.05 area times width, doubled because the mean of S is arbitrary
    there: 0.27, taken as 0.33.
    """
    if not grid.padded:
        return 0.0
    ends = [m * s / grid.a for m, n, s in zip(grid.nominal, grid.n, grid.spacings) if m != n]
    longest = 0.33 * max(ends) if len(ends) == 1 else 0.0
    return float(np.sqrt(grid.N * max(0.958 * np.sqrt(grid.N), longest)))
