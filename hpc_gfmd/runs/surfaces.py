"""Surfaces for a notebook or a script: read, prepared or made as a scene would, on one process."""

import warnings
from collections.abc import Sequence
from dataclasses import replace
from os import PathLike
from typing import Any

import numpy as np

from ..contact.fields import heights_of
from ..parallel.comm import SerialComm
from ..scene import Scene
from ..scene.height_maps import Reading
from ..surface import build_surface
from ..surface.heights import StoredRows, array_of, require_finite
from ..surface.metadata import Metadata, is_topography, missing_numbers, of_topography, unreliable
from ..surface.prepare import prepare
from ..surface.quality import notes_on
from ..surface.topography import Topography, open_topography, topography_of
from ..surface.two_scans import combined, placed
from ..util.errors import GfmdError, SceneError, SurfaceWarning, reason
from .prepared import PreparedSurface

OF_EDGES = {"boundary", "window"}  # keys that say how the surface ends


def read_surface(path: str | PathLike | Sequence[str | PathLike], **keys: Any) -> PreparedSurface:
    """Read a height map of any format and prepare it, on one process.

    Parameters
    ----------
    path
        A .npy, .npz, .txt, .csv, HDF5, NetCDF, TIFF or PNG file, or what SurfaceTopography reads
        (.x3p, .gwy, .spm, ...); a list of two: the sum of two maps, for two rough bodies.
    **keys
        Those of the scene's [surface] with kind = "file", such as physical_sizes=("10 um", "8 um"),
        unit="nm", spikes="median", detrend="tilt", fill="harmonic", crop=(x0, y0, x1, y1),
        boundary="mirror", window="hann", refine=2, downsample=2, flip=True, radius="5 mm",
        height_range=("0 nm", "500 nm"), dataset="name". Sizes in the file are used unless they are
        given here; a unit that contradicts the file is refused. boundary is "mirror" for a piece of
        a larger surface, "free" for a body that ends where the map ends, "periodic", or one for
        each axis; it must be given where opposite edges do not meet.

    Returns
    -------
    PreparedSurface
        Heights of shape (n_x, n_y) and sizes, in m if units are known; its `notes` tell what may be
        wrong with them.

    Raises
    ------
    SceneError
        If it cannot be read, or has no sizes, no unit, points without heights, or no boundary where
        opposite edges do not meet.

    Warns
    -----
    SurfaceWarning
        Of each of its `notes`.
    """
    path = [str(file) for file in path] if isinstance(path, list | tuple) else str(path)
    scene, table = _scene({"kind": "file", "path": path} | keys, "hpc_gfmd.read_surface")
    return _prepared(open_topography(scene.surface), scene.surface).from_table(table)


def prepare_surface(heights: Any, **keys: Any) -> PreparedSurface:
    """Prepare heights that are in memory, as `read_surface` does with those of a file.

    Parameters
    ----------
    heights
        An array (n_x, n_y), peaks up, masked or nan at points without a height; or a Topography of
        SurfaceTopography, also after `.detrend()`, `.to_unit()`, `.scale()` and filters, whose
        sizes, unit and periodicity are used. It is not changed.
    **keys
        Those of `read_surface`. physical_sizes of an array: default (1, 1), in its unit.

    Returns
    -------
    PreparedSurface
        As `read_surface`.

    Raises
    ------
    SceneError
        As `read_surface`, and for a PreparedSurface.
    """
    if isinstance(heights, PreparedSurface):
        raise SceneError(
            "heights: found a PreparedSurface, allowed: an array or a Topography; more keys belong"
            " into the call that made the surface"
        )
    return _prepared(*_in_memory(heights, keys))


def surface_of_topography(topography: Any, boundary: Any) -> PreparedSurface:
    """Return the surface that a Topography of SurfaceTopography shows, which needs sizes, all
    heights and a boundary.
    """
    keys = {} if boundary is None else {"boundary": boundary}
    as_it_is, spec = _in_memory(topography, keys, is_complete=True)
    notes = notes_on(as_it_is, spec, look=False)
    with_notes = replace(as_it_is, notes=(*as_it_is.notes, *notes))
    return _surface(with_notes.mirrored(spec.mirrored), spec)


def _in_memory(
    heights: Any, keys: dict[str, Any], is_complete: bool = False
) -> tuple[Topography, Any]:
    """Return heights in memory as a map, and the [surface] with these keys of `prepare_surface`;
    edges and sizes are the map's where the keys have none. is_complete: heights that are missing
    are refused.
    """
    metadata = Metadata()
    doubts = []
    if is_topography(heights):
        doubt = unreliable(heights)
        if doubt:
            _, note = doubt
            doubts.append(SurfaceWarning(note))
        heights, metadata = of_topography(heights)
    elif not keys.keys() & {"physical_sizes", "unit"}:
        keys = keys | {"physical_sizes": (1.0, 1.0)}
    scene, _ = _scene({"kind": "file", "path": "the array"} | keys, "hpc_gfmd.prepare_surface")
    array = array_of(heights, is_complete)
    if is_complete:
        require_finite(array, 0, "heights")
    numbers = missing_numbers(scene.surface, "an array")
    metadata = replace(metadata, missing=(*metadata.missing, *numbers))
    topography = topography_of(array, metadata, scene.surface)
    return replace(topography, notes=(*topography.notes, *doubts)), scene.surface


def combine_surfaces(
    surface: Any,
    facing: Any,
    *,
    shift: Sequence[Any] = (0.0, 0.0),
    mirrored: str = "x",
    **keys: Any,
) -> PreparedSurface:
    """Add two rough surfaces that face each other to a single one, on one process.

    Along each axis the points of the sum are those of the finer surface (of `surface` if both are
    equally fine); the other one is interpolated there by cubic splines. Along a periodic axis two
    surfaces of equal length are added over the whole period, and the shift wraps around. Along any
    other axis they are added where they overlap.

    Parameters
    ----------
    surface, facing
        Each a PreparedSurface, a Topography of SurfaceTopography, or the path of a height map;
        peaks up.
    shift : (x, y)
        Where the first corner of `facing`, after it was mirrored, lies relative to that of
        `surface`: lengths such as "5 um", or numbers in the unit of the sizes.
    mirrored : str
        Axis along which `facing` is mirrored about its middle, "x" or "y": as a scan from above is
        when its body is turned over to face the other. "none" if x and y of both are the same
        directions in space.
    **keys
        Those of `read_surface`: how files are read, and operations on the sum.

    Returns
    -------
    PreparedSurface
        As `read_surface`. Unless `boundary` or `window` is given, it has free edges along an axis
        where one of the two is a PreparedSurface with free edges.

    Raises
    ------
    SceneError
        As `read_surface`, and for surfaces that do not overlap.
    """
    surfaces = (surface, facing)
    names = ("the first surface", "the second surface")
    paths = [
        str(source) if isinstance(source, str | PathLike) else name
        for source, name in zip(surfaces, names)
    ]
    ends = [_free_edges(source) for source in surfaces]
    if np.any(ends) and not keys.keys() & OF_EDGES:
        keys["boundary"] = ["free" if end else "periodic" for end in np.any(ends, axis=0)]
    bodies = [{"path": paths[0]}, {"path": paths[1], "shift": shift, "mirrored": mirrored}]
    table = {"kind": "file", "bodies": bodies}
    scene, table = _scene(table | keys, "hpc_gfmd.combine_surfaces")
    spec = scene.surface
    scans = [_scan(source, path, spec, keys) for source, path in zip(surfaces, paths)]
    topography = combined(placed((scans[0], scans[1]), spec), spec)
    prepared = _prepared(topography, spec)
    return prepared if set(paths) & set(names) else prepared.from_table(table)


def _free_edges(surface: Any) -> tuple[bool, bool]:
    """Whether a surface has free edges along x, along y; False for all but a PreparedSurface."""
    return surface.free if isinstance(surface, PreparedSurface) else (False, False)


def _scan(surface: Any, path: str, spec: Any, keys: dict[str, Any]) -> Topography:
    """Return one of the surfaces of `combine_surfaces`; `path`: its file, or a name in messages."""
    if isinstance(surface, PreparedSurface):
        of_files = [key for key in keys if key in Reading.model_fields]
        if of_files:
            raise SceneError(
                f"hpc_gfmd.combine_surfaces: found {of_files[0]}, which says how a file is read,"
                f" with {path}, which is prepared, allowed: keys of what is done to the sum"
            )
        return Topography(
            surface.heights.shape,
            surface.sizes,
            StoredRows(surface.heights),
            surface.unit,
            periodic=not any(surface.free) or None,
            path=path,
            plain_unit=surface.unit,
        )
    of_one = spec.model_copy(update={"path": path, "bodies": None})
    if is_topography(surface):
        heights, metadata = of_topography(surface)
        return topography_of(array_of(heights), metadata, of_one)
    if not isinstance(surface, str | PathLike):
        raise SceneError(
            f"hpc_gfmd.combine_surfaces: found {type(surface).__name__} for {path}, allowed: a"
            " path, a Topography, or a surface of hpc_gfmd.prepare_surface(heights,"
            " physical_sizes=...)"
        )
    return open_topography(of_one)


def _prepared(topography: Topography, spec: Any) -> PreparedSurface:
    """Return the PreparedSurface that a [surface] makes of a height map, which is read whole."""
    try:
        prepared = prepare(topography, spec, look=True)
    except MemoryError as error:
        raise GfmdError(f"preparing the surface: {reason(error)}") from None
    for note in prepared.notes:
        warnings.warn(note, stacklevel=3)  # where the caller of read_surface is
    return _surface(prepared, spec)


def _surface(topography: Topography, spec: Any) -> PreparedSurface:
    """Return a PreparedSurface with the heights of a map, copied if they are the caller's."""
    heights = topography.rows(0, topography.n[0])
    if not heights.flags.owndata:  # those of the caller, who may change them
        heights = heights.copy()
    heights.flags.writeable = False
    return PreparedSurface(
        heights,
        topography.sizes,
        topography.unit,
        topography.prepared,
        tuple(map(str, topography.notes)),
        spec.free,
    )


def make_surface(kind: str, **keys: Any) -> PreparedSurface:
    """Make a rough surface from a formula, as a scene would, on one process.

    Parameters
    ----------
    kind
        "self-affine", "spectrum", "fourier", "wave" or "sphere".
    **keys
        Those of the scene's [surface] of that kind: make_surface("self-affine", hurst=0.8,
        L_over_lam_l=2, lam_l_over_lam_s=32, lam_s_over_a=4, seed=1, g_rms=0.1),
        make_surface("sphere", radius="1 mm", n=(256, 256), physical_sizes=("80 um", "80 um")).

    Returns
    -------
    PreparedSurface
        Heights of shape (n_x, n_y), the highest at 0, and sizes, in m if they were given with
        units.

    Raises
    ------
    SceneError
        For keys or values that this kind does not have.
    """
    scene, table = _scene({"kind": kind} | keys, "hpc_gfmd.make_surface")
    surface = build_surface(scene.surface, SerialComm(), np.float64)
    heights = np.asarray(heights_of(surface))
    heights.flags.writeable = False
    prepared = PreparedSurface(
        heights, surface.sizes, scene.length_unit, surface.prepared, free=scene.surface.free
    )
    return prepared.from_table(table)


def _scene(table: dict[str, Any], caller: str) -> tuple[Scene, dict[str, Any]]:
    """Return a scene with `table` as its [surface], and the table in plain Python values."""
    table = {key: plain(value) for key, value in table.items()}
    return Scene.from_dict({"surface": table, "load": {"pressure": 1.0}}, caller), table


def plain(value: Any) -> Any:
    """Convert NumPy numbers, arrays and tuples, also nested, to Python numbers and lists."""
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return value.tolist() if hasattr(value, "tolist") else value
