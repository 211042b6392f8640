"""The formats of instruments and their programs, read by SurfaceTopography."""

from contextlib import redirect_stderr, redirect_stdout
from dataclasses import replace
from io import StringIO
from pathlib import Path

import numpy as np

from ..util.errors import SceneError
from ..util.libraries import surface_topography
from .arrays import of_topography
from .metadata import Metadata

ANY_CHANNEL = "surface"  # the name that nobody gave


def read(path: str | Path, channel: str) -> tuple[np.ndarray, Metadata]:
    """(heights (n_x, n_y), nan where they are missing; Metadata) of one channel of a file. Raises
    whatever is wrong with it."""
    io = surface_topography().IO
    try:
        with (
            redirect_stdout(StringIO()),
            redirect_stderr(StringIO()),
        ):  # some readers print what they miss
            reader = io.open_topography(str(path))
    except io.CannotDetectFileFormat:
        known = ", ".join(io.lookup_reader_by_format)
        raise SceneError(
            f"surface.path: the format of {path} is not known, or it is damaged; known are npy,"
            f" npz, text, hdf5, netcdf and, of instruments, {known}"
        ) from None
    maps = [found for found in reader.channels if found.dim == 2]
    wanted = [found for found in maps if found.name == channel]
    if not maps or (not wanted and channel != ANY_CHANNEL):
        raise ValueError(
            f"surface.dataset = {channel!r}: it has the maps"
            f" {', '.join(str(found.name) for found in maps) or '(none)'}"
        )
    info = wanted[0] if wanted else reader.default_channel
    if info.dim != 2:
        info = maps[0]
    topography = info.topography(
        **({} if info.physical_sizes is not None else {"physical_sizes": (1.0, 1.0)})
    )
    heights, said = of_topography(topography)
    sizes = None if info.physical_sizes is None else said.sizes
    return np.ma.filled(heights, np.nan), replace(said, sizes=sizes)
