"""A rough surface on the grid on which it is solved: what all kinds of surfaces become."""

from collections.abc import Callable
from dataclasses import dataclass
from math import prod

import numpy as np
from numpy.typing import DTypeLike

from ..operators.problem import Columns
from ..parallel.fft import SlabFFT
from ..parallel.grid import Grid
from ..util.errors import SurfaceWarning
from .doubtful_numbers import slope_notes

# the line of `prepared` for a map with its mirror images, by the axes along which it has them
MIRRORED = {
    (True, True): "mirrored",
    (True, False): "mirrored along x",
    (False, True): "mirrored along y",
}


@dataclass(frozen=True)
class Surface:
    """A rough surface on the grid on which it is solved, in the program's units."""

    # Along an axis with free edges it is longer than the surface, see cell.py. For a surface that
    # varies along one axis only it has one point along the other, and every rank holds all of it.
    grid: Grid
    # Initial gap in units of g_rms a, minimum 0, local slab of the nominal area; None once handed
    # over.
    h: np.ndarray | None
    n: tuple[int, ...]  # points along x and y as the scene gives them
    h_rms: float  # realised rms height, in the scene's units
    g_rms: float  # realised rms slope; 0 for a flat surface, whose units are made with g_rms = 1
    rows: tuple[int, int]  # this rank's rows start <= i < stop of the surface with n points
    # Recomputes the heights in Fourier space, see modes.py; None if they have no formula there.
    add_spectrum: Callable[[SlabFFT], Columns] | None = None
    # of the heights as they were read; None if the scene determines them
    checksum: str | None = None
    unit: str = ""  # "m" if sizes and heights are in m, "" if they have no unit
    prepared: tuple[str, ...] = ()  # what was done to a height map, a line each
    map_notes: tuple[SurfaceWarning, ...] = ()  # remarks on a height map for the user

    @property
    def sizes(self) -> tuple[float, ...]:
        """(L_x, L_y) of the surface, in m or without a unit."""
        return self.grid.nominal_sizes

    @property
    def mirrored(self) -> tuple[bool, bool]:
        """Axes along which the surface is a map and its mirror image."""
        axes = (axes for axes, line in MIRRORED.items() if line in self.prepared)
        return next(axes, (False, False))

    @property
    def ridges(self) -> tuple[bool, bool]:
        """Axes along which the surface has kinks where the map meets its mirror image: not if it is
        flat, nor if it was resampled after that, which rounds them.
        """
        is_resampled = any(line.startswith("resampled") for line in self.prepared)
        return (False, False) if self.g_rms == 0 or is_resampled else self.mirrored

    @property
    def images(self) -> int:
        """How often the points of the grid hold the map, itself and mirror images."""
        along = zip(self.mirrored, self.grid.nominal, strict=True)
        return prod(2 for mirrored, n in along if mirrored and n > 1)

    @property
    def notes(self) -> tuple[SurfaceWarning, ...]:
        """Remarks on the surface for the user."""
        return (*slope_notes(self.g_rms, measured=self.checksum is not None), *self.map_notes)

    @property
    def gap(self) -> np.ndarray:
        """The initial gap h; must not be read after h has been handed over (h is None)."""
        assert self.h is not None
        return self.h

    @property
    def slope(self) -> float:
        """The unit of slopes: g_rms, or 1 for a flat surface."""
        return self.g_rms or 1.0

    @property
    def height_unit(self) -> float:
        """The length of one unit of h, u or g, in the scene's unit of length."""
        return self.slope * self.grid.a

    @property
    def reduced_axis(self) -> int | None:
        """Axis along which heights do not change, with one point of `grid`, or None."""
        return next((axis for axis in (0, 1) if self.grid.nominal[axis] != self.n[axis]), None)


@dataclass(frozen=True)
class ByHeights:
    """A precision that depends on a surface, whose gap is still missing; `of` returns it."""

    of: Callable[[Surface], np.dtype]


Precision = DTypeLike | ByHeights  # of the gap of a surface to make


def precision_of(precision: Precision, surface: Surface) -> np.dtype:
    """Return the precision of the gap of a surface."""
    if isinstance(precision, ByHeights):
        return precision.of(surface)
    return np.dtype(precision)
