"""Height maps in memory: arrays, masked arrays, and Topography objects of SurfaceTopography."""

from os import PathLike
from typing import Any

import numpy as np

from ..util.errors import SceneError, one_line
from ..util.quantities import factor, prefixed
from .heights import A_MAP, require_map
from .metadata import Map, Metadata, is_y_first

EXACT = 2**53  # float64 holds all integers up to this one


def is_topography(value: Any) -> bool:
    """Whether an object looks like a Topography of SurfaceTopography, which is not imported."""
    return callable(getattr(value, "heights", None)) and hasattr(value, "physical_sizes")


def of_topography(topography: Any) -> Map:
    """Return heights (float64, masked where missing) and metadata of a Topography of
    SurfaceTopography.

    It is periodic if the Topography is; otherwise that is left open, since most formats say nothing
    of it.
    """
    named = topography
    while isinstance(named.unit, dict):  # mirror_stitch of 1.27 forgets its parent's
        named = named.parent_topography
    unit = named.unit
    sizes_unit, unit = unit if isinstance(unit, tuple | list) else (unit, unit)
    sizes = None
    if topography.physical_sizes is not None:
        sizes = tuple(map(float, topography.physical_sizes))
    # Most formats know nothing of periodicity, and are said to be not periodic.
    metadata = Metadata(sizes, sizes_unit, unit, bool(topography.is_periodic) or None)
    return np.ma.asarray(topography.heights(), dtype=np.float64), metadata


def unreliable(topography: Any) -> tuple[float, str] | None:
    """Return the wave length in m below which a Topography shows the instrument, and a note on it,
    or None.

    That is the limit set by the tip or the resolution of the instrument, as SurfaceTopography knows
    it.
    """
    has_unit = isinstance(topography.unit, str)
    cutoff = topography.short_reliability_cutoff() if has_unit else None
    if cutoff is None:
        return None
    length = cutoff * factor(topography.unit)
    scale, name = prefixed([length], "m")
    return length, (
        f"waves shorter than {length / scale:.3g} {name} show the instrument, not the surface"
        " (SurfaceTopography's short_reliability_cutoff)"
    )


def checked_array(heights: Any) -> np.ndarray:
    """Return heights as an array (a masked array stays one); the values are not read.

    Raises SceneError if it is a path, is not a non-empty real array with two axes, or is an array
    of xarray whose first axis is y.
    """
    if isinstance(heights, str | PathLike):
        path = repr(str(heights))
        raise SceneError(
            f"heights: found {path}, allowed: an array, or hpc_gfmd.read_surface({path})"
        )
    names = [str(name) for name in getattr(heights, "dims", ())]
    if len(names) == 2 and is_y_first([(name, {}) for name in names]):
        raise SceneError(
            f"heights: found axes {names[0]}, {names[1]}, allowed: x, y, as of"
            f' heights.transpose("{names[1]}", "{names[0]}")'
        )
    try:
        heights = np.asanyarray(heights)
    except (TypeError, ValueError) as error:
        raise SceneError(f"heights: found {one_line(str(error))}, allowed: {A_MAP}") from None
    require_map(heights, "heights")
    return _from_lowest(heights)


def _from_lowest(heights: np.ndarray) -> np.ndarray:
    """Return heights; integers that float64 does not hold are counted from the lowest of them."""
    if heights.dtype.kind not in "iu" or heights.dtype.itemsize < 8:
        return heights
    lowest = heights.min()
    if lowest is np.ma.masked or max(abs(int(lowest)), abs(int(heights.max()))) <= EXACT:
        return heights
    # unsigned arithmetic is modulo 2^64: the differences are right even if int64 does not hold them
    return heights.astype(np.uint64) - np.uint64(int(lowest) % 2**64)


def complete_array(heights: Any) -> np.ndarray:
    """Convert heights to an array as `checked_array`, and refuse masked points, but not nan."""
    heights = checked_array(heights)
    if np.ma.is_masked(heights):
        raise SceneError(
            f"heights: found {np.ma.count_masked(heights)} masked points, allowed: a complete map,"
            ' as of hpc_gfmd.prepare_surface(heights, fill="harmonic")'
        )
    return heights
