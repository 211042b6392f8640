"""From the scene's [surface] to the gap under zero load, in the program's units (see problem.py)."""

from dataclasses import dataclass, replace

import numpy as np

from ..errors import SceneError
from ..grid import Grid
from ..parallel.comm import SerialComm
from ..parallel.guard import guarded
from ..units import LARGEST_HEIGHT
from .analytic import sphere_rows, wave_rows
from .doubts import by_slope
from .heights import Checksum, checked
from .prepare import prepare, prepared_size
from .selfaffine import self_affine_gap
from .statistics import rms
from .topography import open_topography

SLAB_ROWS = 64  # rows read or made at a time


@dataclass(frozen=True)
class Surface:
    """h: initial gap, local slab of `grid`, >= 0 with minimum 0, in units of g_rms a; h_rms, g_rms: realised, in the scene's units.

    A surface that varies along one axis only lives on a grid with one point along the other; `n` is the size asked for, and every
    rank then holds all of `grid`. A flat surface has g_rms = 0 and h in the scene's unit. rows: (start, stop) of the size asked for
    that this rank owns. add_spectrum: see selfaffine.py, or None where heights are not known by their spectrum. checksum: of the
    heights as they were read, None where the scene says all about them. unit: "m" where sizes and heights are in it, "" where nobody
    named their unit. prepared: what was done to a height map, a line each. doubts: see
    doubts.py.
    """

    grid: Grid
    h: np.ndarray
    n: tuple[int, int]
    h_rms: float
    g_rms: float
    rows: tuple[int, int]
    add_spectrum: object = None
    checksum: str | None = None
    unit: str = ""
    prepared: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()

    @property
    def notes(self):
        """What to know of it before the numbers, a line each."""
        return (*by_slope(self.g_rms, measured=self.checksum is not None), *self.doubts)

    @property
    def height_unit(self):
        """What one unit of h, u or g is in the scene's unit of length."""
        return self.g_rms * self.grid.a if self.g_rms > 0 else 1.0

    @property
    def reduced_axis(self):
        """The axis that was left out (0 or 1), or None."""
        return next((axis for axis in (0, 1) if self.grid.n[axis] != self.n[axis]), None)


def surface_size(spec):
    """(n_x, n_y) of a surface; opens the file where only that knows, after a test that it can be opened. Raises SceneError."""
    return tuple(spec.n) if spec.n is not None else prepared_size(open_topography(spec, probe=True), spec)


def build_surface(spec, comm, dtype, threads=1, thrifty=False):
    """Make or read the surface of a scene on all ranks; spec: scene.surface. Raises SceneError on all ranks.

    thrifty: without transforms in double precision, which later ones of the certificate would need anyway.
    """
    dtype = np.dtype(dtype)
    if spec.kind == "self-affine":
        grid = Grid(spec.n, spec.physical_sizes, comm, threads)
        h, h_over_g, add_spectrum = self_affine_gap(spec, grid, dtype, dtype if thrifty else np.float64)
        g_rms = spec.g_rms if spec.g_rms is not None else spec.h_rms / (h_over_g * grid.a)
        return Surface(grid, h, spec.n, h_over_g * g_rms * grid.a, g_rms, grid.rows, add_spectrum)
    if spec.kind != "file":
        rows = {"wave": wave_rows, "sphere": sphere_rows}[spec.kind](spec, spec.n)
        return surface_from_rows(spec.n, spec.physical_sizes, rows, comm, dtype, threads)
    with guarded(comm, "reading the surface"):
        found = open_topography(spec)
    found, done, notes = prepare(found, spec, comm)
    made = surface_from_rows(found.n, found.sizes, found.rows, comm, dtype, threads, Checksum(), found.unit)
    return replace(made, prepared=done, doubts=notes)


def surface_from_rows(n, sizes, rows, comm, dtype, threads=1, checksum=None, unit=""):
    """The surface whose heights rows(start, stop) gives as float64 (stop - start, n_y). Raises SceneError on all ranks.

    checksum: an empty heights.Checksum where one is wanted.
    """
    grid = Grid(n, sizes, comm, threads)
    start, stop = grid.rows
    z = grid.empty(np.float64)
    with guarded(comm, "reading the surface"):
        for i in range(0, stop - start, SLAB_ROWS):
            z[i:i + SLAB_ROWS] = checked(rows(start + i, min(start + i + SLAB_ROWS, stop)), start + i, "surface")
            if checksum is not None:
                checksum.add(z[i:i + SLAB_ROWS])
    known = checksum.of_all(comm, n, sizes, unit) if checksum is not None else None
    top = float(comm.max([z.max(initial=-np.inf)])[0])
    np.subtract(top, z, out=z)  # now the gap, exact where it is small
    grid, z = _leave_out_constant_axis(grid, z)
    span = float(grid.comm.max([z.max(initial=0)])[0])
    if span == 0.0:
        return Surface(grid, z.astype(dtype), n, 0.0, 0.0, (start, stop), checksum=known, unit=unit)
    if span < 1 / LARGEST_HEIGHT:
        raise SceneError(f"surface: found heights that differ by {span:g} at most, allowed: 0 or at least {1 / LARGEST_HEIGHT:g}")
    centre = float(grid.comm.sum([z.sum()])[0]) / grid.N
    scale = float(grid.comm.max([np.abs(z - centre).max(initial=0)])[0])

    def fill(i0, i1, x):
        np.subtract(z[i0:i1], centre, out=x[: i1 - i0])
        x[: i1 - i0] /= scale  # heights of 1e-200 or 1e200 have squares too

    h_rms, g_rms = (scale * r for r in rms(grid, fill))
    if dtype != np.float64:
        grid.forget_fft(np.float64)
    h = z if dtype == np.float64 else np.empty(z.shape, dtype)
    np.divide(z, g_rms, out=h, casting="same_kind")
    return Surface(grid, h, n, h_rms, g_rms / grid.a, (start, stop), checksum=known, unit=unit)


def _leave_out_constant_axis(grid, z):
    """Where heights vary along one axis only, the grid and the heights (on every rank) of that axis alone."""
    comm, n = grid.comm, grid.n
    if 1 in n:
        axis = None
    else:
        first = next(row for row in comm.allgather(z[0] if len(z) else None) if row is not None)
        along_y = not np.any(z != first)
        along_x = not np.any(z != z[:, :1])
        different = comm.max([not along_y, not along_x])
        axis = 0 if not different[0] else (1 if not different[1] else None)
    if axis is None:
        return grid, z
    if axis == 0:
        return Grid((1, n[1]), grid.sizes, SerialComm()), first[None].copy()
    column = np.concatenate(comm.allgather(z[:, 0].copy()))
    return Grid((n[0], 1), grid.sizes, SerialComm()), column[:, None].copy()
