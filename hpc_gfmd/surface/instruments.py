"""The formats of instruments and their programs, read by SurfaceTopography."""

from contextlib import redirect_stderr, redirect_stdout, suppress
from dataclasses import replace
from io import StringIO
from pathlib import Path
from typing import Any

from ..scene.surface import ANY
from ..util.errors import SceneError
from ..util.libraries import surface_topography
from .arrays import of_topography
from .metadata import Map


def read(path: str | Path, spec: Any) -> Map:
    """Read one channel of a file: (heights (n_x, n_y), masked where they are missing; Metadata);
    spec: scene.File. Raises whatever is wrong with the file."""
    topography, sized = opened(path, spec.dataset)
    heights, said = of_topography(topography)
    return heights, said if sized else replace(said, sizes=None)


def recognised(path: str | Path, spec: Any) -> Map | None:
    """Read a file as `read` does if it says something of its sizes or units; None for others."""
    with suppress(Exception):
        found = read(path, spec)
        return found if found[1].sizes or found[1].unit else None
    return None


def opened(path: str | Path, channel: str) -> tuple[Any, bool]:
    """Open the Topography of one channel of a file, and tell whether the file knows its sizes."""
    io = surface_topography().IO
    quiet = StringIO()  # some readers print what they miss
    try:
        with redirect_stdout(quiet), redirect_stderr(quiet):
            reader = io.open_topography(str(path))
    except io.CannotDetectFileFormat:
        known = ", ".join(io.lookup_reader_by_format)
        raise SceneError(
            f"surface.path: the format of {path} is not known, or it is damaged; known are npy,"
            f" npz, text, hdf5, netcdf, tiff, png and, of instruments, {known}"
        ) from None
    maps = [found for found in reader.channels if found.dim == 2]
    if not maps:
        raise ValueError("it has no map of heights, only profiles")
    wanted = [found for found in maps if found.name == channel]
    if not wanted and channel != ANY:
        raise ValueError(
            f"surface.dataset = {channel!r}: it has the maps"
            f" {', '.join(str(found.name) for found in maps)}"
        )
    info = next(found for found in (*wanted, reader.default_channel, *maps) if found.dim == 2)
    sized = info.physical_sizes is not None
    return info.topography(**({} if sized else {"physical_sizes": (1.0, 1.0)})), sized
