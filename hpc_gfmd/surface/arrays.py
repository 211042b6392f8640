"""Height maps in memory: arrays, masked arrays, and Topography objects of SurfaceTopography."""

from os import PathLike
from typing import Any

import numpy as np

from ..util.errors import SceneError, one_line
from ..util.quantities import factor, prefixed
from .heights import A_MAP, require_map
from .metadata import Map, Metadata


def is_topography(found: Any) -> bool:
    """Tell whether an object is a Topography of SurfaceTopography, which is not imported
    for that."""
    return callable(getattr(found, "heights", None)) and hasattr(found, "physical_sizes")


def of_topography(found: Any) -> Map:
    """Return the heights of a Topography, masked where there are none, and what it says of them."""
    named = found
    while isinstance(named.unit, dict):  # mirror_stitch of 1.27 forgets its parent's
        named = named.parent_topography
    unit = named.unit
    sizes_unit, unit = unit if isinstance(unit, tuple | list) else (unit, unit)
    sizes = None if found.physical_sizes is None else tuple(map(float, found.physical_sizes))
    # Most formats know nothing of periodicity, and are said to be not periodic.
    said = Metadata(sizes, sizes_unit, unit, bool(found.is_periodic) or None)
    return np.ma.asarray(found.heights(), dtype=np.float64), said


def unreliable(found: Any) -> tuple[float, str] | None:
    """Return the wave length in m below which a Topography shows the tip or the resolution of the
    instrument rather than the surface, and what to say of it; None where it does not know."""
    named = isinstance(found.unit, str)
    cutoff = found.short_reliability_cutoff() if named else None
    if cutoff is None:
        return None
    length = cutoff * factor(found.unit)
    scale, name = prefixed([length], "m")
    return length, (
        f"waves shorter than {length / scale:.3g} {name} show the instrument, not the surface"
        " (SurfaceTopography's short_reliability_cutoff)"
    )


def checked_array(heights: Any) -> np.ndarray:
    """Return the heights as an array. Raises SceneError for what is no height map."""
    if isinstance(heights, str | PathLike):
        path = repr(str(heights))
        raise SceneError(
            f"heights: found {path}, allowed: an array, or hpc_gfmd.read_surface({path})"
        )
    if [str(name).lower() for name in getattr(heights, "dims", ())] == ["y", "x"]:
        raise SceneError(
            'heights: found axes y, x, allowed: x, y, as of heights.transpose("x", "y")'
        )
    try:
        heights = np.asanyarray(heights)
    except (TypeError, ValueError) as error:
        raise SceneError(f"heights: found {one_line(str(error))}, allowed: {A_MAP}") from None
    require_map(heights, "heights")
    return heights
