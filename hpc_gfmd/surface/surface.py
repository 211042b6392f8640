"""A rough surface on the grid on which it is solved: what all kinds of surfaces become."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..operators.problem import Columns
from ..parallel.fft import SlabFFT
from ..parallel.grid import Grid
from ..util.errors import SurfaceWarning
from .doubtful_numbers import slope_notes


@dataclass(frozen=True)
class Surface:
    """A rough surface on the grid on which it is solved, in the program's units.

    Attributes
    ----------
    grid : Grid
        Along an axis with free edges it is longer than the surface, see cell.py. For a surface that
        varies along one axis only it has one point along the other, and every rank holds all of it.
    h : ndarray
        Initial gap in units of g_rms a, >= 0 with minimum 0: this rank's part of the nominal area
        of `grid`. None after it has been handed over.
    n : (int, int)
        Points along x and y as the scene gives them.
    h_rms, g_rms : float
        Realised rms height and slope, in the scene's units. For a flat surface g_rms = 0, and units
        are made with g_rms = 1 instead.
    rows : (int, int)
        This rank's rows start <= i < stop of the surface with n points.
    add_spectrum : function, optional
        Recomputes the heights in Fourier space, see modes.py; None if they have no formula
        there.
    checksum : str, optional
        Checksum of the heights as they were read; None if the scene determines them.
    unit : str
        "m" if sizes and heights are in m, "" if they have no unit.
    prepared : tuple of str
        What was done to a height map, a line each.
    map_notes : tuple of SurfaceWarning
        Remarks on a height map for the user.
    """

    grid: Grid
    h: np.ndarray | None
    n: tuple[int, ...]
    h_rms: float
    g_rms: float
    rows: tuple[int, int]
    add_spectrum: Callable[[SlabFFT], Columns] | None = None
    checksum: str | None = None
    unit: str = ""
    prepared: tuple[str, ...] = ()
    map_notes: tuple[SurfaceWarning, ...] = ()

    @property
    def sizes(self) -> tuple[float, ...]:
        """(L_x, L_y) of the surface, in m or without a unit."""
        return self.grid.nominal_sizes

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
        """Axis (0 or 1) along which heights do not change, so that `grid` has one point there.

        None if `grid` has all points of the surface, as it always does with free edges.
        """
        return next((axis for axis in (0, 1) if self.grid.nominal[axis] != self.n[axis]), None)
