"""From the scene's [surface] to the gap under zero load, in the program's units."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ..parallel.comm import SerialComm
from ..parallel.grid import Grid
from ..parallel.guard import collective_errors, on_rank_0, raise_on_all
from ..parallel.interrupt import check
from ..parallel.threads import PIECE_ROWS
from ..scene import has_unit
from ..util.errors import SceneError
from .analytic import flat_rows, wave_rows
from .cell import grid_of, nominal_part
from .fourier import fourier_modes
from .height_distribution import with_distribution
from .heights import LARGEST, Rows, StoredRows, checksum, collected, require_finite, sums_of_rows
from .modes import gap_of_modes
from .prepare import (
    asks_for_preparation,
    bytes_of_preparing,
    complete,
    on_radius,
    prepare,
    prepared_size,
)
from .quality import notes_on
from .spectrum import self_affine_modes, spectrum_modes
from .statistics import Roughness, rms, rms_between_neighbours
from .surface import ByHeights, Precision, Surface, precision_of
from .topography import Topography, open_topography

MODES = {"self-affine": self_affine_modes, "spectrum": spectrum_modes, "fourier": fourier_modes}


class Size(NamedTuple):
    """How large a surface is, before it is made."""

    n: tuple[int, int]  # points along x and y
    lengths: tuple[float, ...]  # (L_x, L_y)
    # bytes of the process that reads and prepares a map; 0 where each rank makes or reads its rows
    preparing: float = 0.0


def open_surface(spec: Any) -> tuple[Topography | None, Size]:
    """Return the opened map of a [surface] (None without a file) and its size. Not collective."""
    if spec.n is not None:
        return None, Size(tuple(spec.n), spec.physical_sizes)
    topography = open_topography(spec)
    is_whole = topography.stored or asks_for_preparation(spec)
    preparing = bytes_of_preparing(topography, spec) if is_whole else 0.0
    return topography, Size(*prepared_size(topography, spec), preparing)


def surface_size(spec: Any) -> Size:
    """Return the size of a surface; see `open_surface`."""
    _, size = open_surface(spec)
    return size


def build_surface(
    spec: Any,
    comm: Any,
    dtype: Precision,
    threads: int = 1,
    low_memory: bool = False,
    whole: bool = False,
    opened: Callable[[], Topography | None] = lambda: None,
) -> Surface:
    """Make or read the surface of a scene, each rank its own rows. Collective. low_memory:
    transforms of self-affine surfaces in the precision of the gap; whole: keep both axes; opened():
    the map, if it is open on this rank.
    """
    if spec.kind == "file":
        shared = partial(_shared, spec, comm, opened)
        return surface_of(shared(), comm, dtype, threads, spec.free, True, whole)
    if getattr(spec, "has_distribution", False):
        shared = partial(_on_rank_0, partial(_with_distribution, spec), spec, comm)
        return surface_of(shared(), comm, dtype, threads, spec.free, whole=whole)
    if spec.kind in MODES:
        made = _made_of_modes(spec, comm, dtype, threads, low_memory)
        if not spec.radius:
            return made
        on_form = surface_of(_on_form(spec, _rows_of_gap(made)), comm, dtype, threads, spec.free)
        return replace(on_form, checksum=made.checksum, prepared=made.prepared)
    rows = wave_rows(spec) if spec.kind == "wave" else flat_rows
    return surface_of(_on_form(spec, rows), comm, dtype, threads, spec.free, whole=whole)


def _on_form(spec: Any, rows: Rows) -> Topography:
    """Return heights, given by rows, on the form of a scene's [surface]."""
    form_alone = spec.kind == "sphere"  # whose summit is a point of the grid
    return Topography(spec.n, spec.physical_sizes, rows).on_form(spec.radii, form_alone)


def _made_of_modes(
    spec: Any, comm: Any, dtype: Precision, threads: int, low_memory: bool
) -> Surface:
    """Return the surface of a kind in MODES, without its form, see `build_surface`. Collective.
    low_memory: a precision that does not depend on the heights.
    """
    kept: Precision = np.float64 if spec.radius else dtype
    made_in = np.float64 if isinstance(kept, ByHeights) or not low_memory else kept
    modes = MODES[spec.kind](spec, comm)
    grid = grid_of(spec.n, spec.physical_sizes, comm, spec.free, threads)
    nominal = nominal_part(grid)

    def without_gap(roughness: Roughness) -> Surface:
        if roughness.g_rms == 0:
            raise SceneError(
                "surface: found no wave of the cell in the spectrum, allowed: at least one"
            )
        if spec.g_rms is not None:
            unit = spec.g_rms * grid.a / roughness.g_rms
        elif spec.h_rms is not None:
            unit = spec.h_rms / roughness.h_rms
        else:
            assert modes.unit is not None
            unit = modes.unit
        in_lengths = roughness.in_units(unit, grid.a)
        return Surface(
            grid,
            None,
            spec.n,
            h_rms=in_lengths.h_rms,
            g_rms=in_lengths.g_rms if spec.g_rms is None else spec.g_rms,
            rows=grid.nominal_rows,
            checksum=modes.checksum,
            prepared=modes.prepared(in_lengths) if modes.prepared else (),
        )

    h, roughness, add_spectrum = gap_of_modes(
        modes, nominal, lambda roughness: precision_of(kept, without_gap(roughness)), made_in
    )
    if grid.padded:  # what is solved on has transforms of its own
        nominal.forget_fft(made_in)
    known = None if grid.padded else add_spectrum
    return replace(without_gap(roughness), h=h, add_spectrum=known)


def _with_distribution(spec: Any) -> Topography:
    """Return the surface of a scene of modes with the distribution of heights that it asks for."""
    alone = spec.model_copy(update={"boundary": "periodic", "radius": None})
    made = _made_of_modes(alone, SerialComm(), np.dtype(np.float64), 1, low_memory=False)
    heights, line = with_distribution(-made.height_unit * made.gap, spec)
    unit = "m" if has_unit(spec.physical_sizes) else ""
    topography = Topography(spec.n, spec.physical_sizes, StoredRows(heights), unit)
    return replace(topography, prepared=(*made.prepared, line)).on_form(spec.radii)


def _rows_of_gap(surface: Surface) -> Rows:
    """Return a function (start, stop) -> rows of the heights, of those that this rank has."""
    begin = surface.rows[0]
    return lambda start, stop: -surface.height_unit * surface.gap[start - begin : stop - begin]


def _shared(spec: Any, comm: Any, opened: Callable[[], Topography | None]) -> Topography:
    """Return the prepared map, read and prepared by rank 0 unless it lies in an array in a file
    that needs no preparation, of which each rank reads its own rows. Collective.
    """
    handed: list[Topography] = []  # so that nothing here refers to the map while it is prepared
    is_read_by_rows = False
    with collective_errors(comm, "reading the surface"):
        if comm.rank == 0:
            handed.append(opened() or open_topography(spec))
            is_read_by_rows = not handed[0].stored and not asks_for_preparation(spec)
    if comm.bcast(is_read_by_rows):
        return _read_by_rows(handed[0] if handed else None, spec, comm)
    return _on_rank_0(lambda: prepare(handed.pop(), spec), spec, comm)


def _on_rank_0(make: Callable[[], Topography], spec: Any, comm: Any) -> Topography:
    """Return the heights that make() returns on rank 0, each rank its rows. Collective."""
    about = None  # the map without its heights
    with collective_errors(comm, "reading the surface"):
        if comm.rank == 0:
            topography = make()
            z = np.ascontiguousarray(topography.heights())
            about = replace(topography, rows=flat_rows, bodies=())
            del topography
    shared = comm.bcast(about)
    starts = nominal_part(grid_of(shared.n, shared.sizes, comm, spec.free)).starts
    begin, end = starts[comm.rank : comm.rank + 2]
    if comm.rank > 0:
        z = np.empty((end - begin, shared.n[1]))
        comm.exchange({}, {0: z})
    elif comm.size > 1:
        comm.exchange({k: z[starts[k] : starts[k + 1]] for k in range(1, comm.size)}, {})
        z = z[begin:end].copy()
    return replace(shared, rows=StoredRows(z, int(begin)))


def _read_by_rows(topography: Topography | None, spec: Any, comm: Any) -> Topography:
    """Return a map that each rank reads by rows, if all find the same one. Collective."""
    with collective_errors(comm, "reading the surface"):
        if topography is None:
            topography = open_topography(spec)
        measured = complete(topography)
    size = measured.n, measured.sizes, measured.unit
    differs = SceneError(
        f"surface.path: found other points, sizes or units of {measured.path} on some ranks,"
        " allowed: the same file on all"
    )
    raise_on_all(comm, None if comm.bcast(size) == size else differs)
    notes = on_rank_0(comm, "reading the surface", lambda: notes_on(measured, spec, look=False))
    return on_radius(replace(measured, notes=(*measured.notes, *notes)), spec)


def surface_of(
    topography: Topography,
    comm: Any,
    dtype: Precision,
    threads: int,
    free: tuple[bool, bool],
    with_checksum: bool = False,
    whole: bool = False,
) -> Surface:
    """Make the Surface of a prepared map, whose heights are read here. Collective. g_rms is from
    neighbours beside free edges, else from the Fourier series; one that varies along one axis only
    keeps one point along the other, unless `whole`.
    """
    n = topography.n
    sizes = topography.sizes
    cell = grid_of(n, sizes, comm, free, threads)
    grid = nominal_part(cell)
    with collective_errors(comm, "reading the surface"):
        z = np.ascontiguousarray(collected(topography.rows, *grid.rows, grid.n[1]))
        lowest, top, total, sums = _range_of(z, grid, with_checksum)
    check(comm)
    made = partial(
        Surface,
        n=n,
        rows=grid.rows,
        unit=topography.unit,
        prepared=topography.prepared,
        map_notes=topography.notes,
        checksum=checksum(comm, sums, n, sizes, topography.unit) if with_checksum else None,
    )
    del topography  # it may hold heights that are not needed any more
    depth, top = comm.max([-lowest, top])
    centre = float(comm.sum([total])[0]) / grid.N
    span = float(depth + top)
    if not cell.padded and not whole:
        grid, z = _leave_out_constant_axis(grid, z, top)
        cell = grid
    if span == 0.0:
        flat = made(cell, None, h_rms=0.0, g_rms=0.0)
        return replace(flat, h=np.zeros(z.shape, precision_of(dtype, flat)))
    if span < 1 / LARGEST:
        raise SceneError(
            f"surface: found heights that differ by {span:g} at most, allowed: 0 or at least"
            f" {1 / LARGEST:g}"
        )

    def fill(i0: int, i1: int, x: np.ndarray) -> None:
        np.subtract(centre, z[i0:i1], out=x[: i1 - i0])  # of a small mean, which counts for nothing

    h_rms, g_rms = rms_between_neighbours(grid, fill, free) if cell.padded else rms(grid, fill)
    surface = made(cell, None, h_rms=h_rms, g_rms=g_rms / grid.a)
    h = grid.empty(precision_of(dtype, surface))
    if h.dtype != np.float64:
        grid.forget_fft(np.float64)

    def divide(i0: int, i1: int) -> None:
        gap = np.subtract(top, z[i0:i1])  # exact where it is small
        np.divide(gap, g_rms, out=h[i0:i1], casting="same_kind")

    grid.by_rows(divide)
    return replace(surface, h=h)


def _range_of(z: np.ndarray, grid: Grid, with_sums: bool) -> tuple[float, float, float, bytes]:
    """Return the lowest and the highest of this rank's heights, their sum, and with_sums
    `sums_of_rows`; SceneError for heights that are not finite or too large.
    """

    def of_piece(i0: int, i1: int) -> tuple[float, float, float, bytes]:
        rows = z[i0:i1]
        with np.errstate(invalid="ignore"):  # infinite heights are refused below
            total = rows.sum()
        return rows.min(), rows.max(), total, sums_of_rows(rows) if with_sums else b""

    pieces = grid.by_rows(of_piece)
    lowest = np.min([low for low, _, _, _ in pieces], initial=np.inf)
    highest = np.max([high for _, high, _, _ in pieces], initial=-np.inf)
    if len(z) and not -LARGEST <= lowest <= highest <= LARGEST:
        require_finite(z, grid.rows[0], "surface")
    total = sum(total for _, _, total, _ in pieces)
    return lowest, highest, total, b"".join(sums for _, _, _, sums in pieces)


def _leave_out_constant_axis(grid: Grid, z: np.ndarray, top: float) -> tuple[Grid, np.ndarray]:
    """Return grid and heights, the whole line on every rank with one point along the other axis if
    the gap below `top` varies along one axis only; a constant map keeps y. Collective.
    """
    comm = grid.comm
    line = comm.bcast(z[:1].copy())

    def differs(other: Callable[[np.ndarray], np.ndarray]) -> bool:
        """Whether some rows have another gap than other(rows); the first few mostly tell."""
        pieces = (z[i : i + PIECE_ROWS] for i in range(0, len(z), PIECE_ROWS))
        return any(np.any(top - rows != top - other(rows)) for rows in pieces)

    along_x, along_y = comm.max([differs(lambda rows: line), differs(lambda rows: rows[:, :1])])
    if 1 in grid.n or (along_x and along_y):
        return grid, z
    if along_x:
        line = np.concatenate(comm.allgather(z[:, :1]))
    return Grid.kept(line.shape, grid.sizes, SerialComm()), line
