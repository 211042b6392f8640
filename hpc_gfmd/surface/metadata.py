"""What a file, or a Topography of SurfaceTopography, says about its heights: sizes, units,
directions, whether they are periodic.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..scene.table import MAX_N
from ..util.errors import SceneError
from ..util.lengths import length_factor
from ..util.quantities import prefixed

UNEVEN = 1e-3  # of a step: coordinates that differ by more are not those of a grid
ATTRIBUTES = ("physical_sizes", "unit", "units", "periodic")
_X_NAMES = ("x", "lon", "longitude", "easting", "column", "columns", "col", "cols", "width")
_Y_NAMES = ("y", "lat", "latitude", "northing", "row", "rows", "line", "lines", "height")
_X_STANDARD = ("projection_x_coordinate", "longitude", "grid_longitude")
_Y_STANDARD = ("projection_y_coordinate", "latitude", "grid_latitude")


@dataclass(frozen=True)
class Metadata:
    """What a file says about its heights; None or empty if it says nothing."""

    sizes: tuple[float, ...] | None = None  # in sizes_unit
    sizes_unit: str | None = None  # as the file writes it; it need not be a unit of length
    unit: str | None = None  # of the heights, as the file writes it
    periodic: bool | None = None  # True if the file says so; None otherwise
    transposed: bool = False  # whether the first axis of the array is y
    # whether coordinates fall along x, along y: heights are reversed when they are read
    falling: tuple[bool, ...] = (False, False)
    # along what x runs in the file, as a phrase for the user
    direction: str = "along the first index of the array"
    direction_known: bool = True  # whether the file itself says which direction is x
    channel: str = ""  # that was read, if there are several
    other_channels: tuple[str, ...] = ()  # that were not read
    missing: tuple[float, ...] = ()  # numbers that stand for missing heights
    remarks: tuple[str, ...] = ()  # what the user should know of how the file was read, a line each
    reader: str = ""  # the format as which the file was read
    file_bytes: int = 0  # of the file, unpacked


Map = tuple[Any, Metadata]  # an array, or anything sliced like one, and what is said of it


def is_topography(value: Any) -> bool:
    """Whether an object looks like a Topography of SurfaceTopography, which is not imported."""
    return callable(getattr(value, "heights", None)) and hasattr(value, "physical_sizes")


def of_topography(topography: Any) -> Map:
    """Return heights (n_x, n_y), float64, masked, and metadata of a Topography; unless it is
    periodic that is left open, as most formats do not say.
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
    """Return the wave length in m below which a map shows the instrument, and a note, or None."""
    metres = length_factor(topography.unit) if isinstance(topography.unit, str) else None
    cutoff = topography.short_reliability_cutoff() if metres else None
    if metres is None or cutoff is None:
        return None
    length = cutoff * metres
    scale, name = prefixed([length], "m")
    return length, (
        f"waves shorter than {length / scale:.3g} {name} show the instrument, not the surface"
        " (SurfaceTopography's short_reliability_cutoff)"
    )


def by_attributes(*places: Mapping[str, Any]) -> Metadata:
    """Make metadata of the attributes physical_sizes, unit(s) and periodic of heights, then of the
    file; sizes are in the unit beside them, or else that of the heights.
    """

    def first_with(name: str) -> Mapping[str, Any]:
        return next((place for place in places if name in place), {})

    beside_sizes = first_with("physical_sizes")
    unit = next(filter(None, map(unit_in, places)), None)
    sizes = np.ravel(beside_sizes.get("physical_sizes", ())).astype(float)
    periodic = bool(np.all(first_with("periodic").get("periodic", False)))
    return Metadata(
        sizes=tuple(sizes.tolist()) if len(sizes) == 2 else None,
        sizes_unit=unit_in(beside_sizes) or unit,
        unit=unit,
        periodic=periodic or None,
    )


def by_axes(heights: Mapping[str, Any], axes: list) -> Metadata:
    """Make metadata of a NetCDF variable and two axes (name, attributes, coordinates or None), by
    `length` and `unit` (SurfaceTopography) or coordinates and `units` (CF). Coordinates that only
    count points do not count.
    """
    names = tuple(name for name, *_ in axes)
    transposed = is_y_first([(name, attributes) for name, attributes, _ in axes])
    _, attributes, coordinates = zip(*(axes[::-1] if transposed else axes))
    lengths = list(map(_length, attributes, coordinates))
    units = list(map(unit_in, attributes))
    has_sizes = all(length is not None for length in lengths)
    if has_sizes and units[0] != units[1]:
        raise ValueError(f"its axes are in different units, {units[0]} and {units[1]}")
    has_lengths = all("length" in axis for axis in attributes)
    unit = unit_in(heights) or (units[0] if has_lengths else None)
    remarks: tuple[str, ...] = ()
    if has_sizes and not has_lengths and units[0] is None and (unit or _are_indices(coordinates)):
        has_sizes = False
        remarks = ("the coordinates of the points have no unit: they are not used",)
    return Metadata(
        sizes=tuple(abs(length) for length in lengths if length is not None) if has_sizes else None,
        sizes_unit=units[0],
        unit=unit,
        periodic=all(np.all(axis.get("periodic", False)) for axis in attributes) or None,
        transposed=transposed,
        falling=tuple(length is not None and length < 0 for length in lengths),
        direction=f"along the axis {names[transposed]!r} of {names[0]!r}, {names[1]!r}",
        direction_known=is_x_or_y(axes),
        remarks=remarks,
    )


def is_y_first(axes: list[tuple[str, Mapping[str, Any]]]) -> bool:
    """Whether the first of two axes, (name, attributes), is y, by CF's attributes or its name."""
    return [_direction(*axis) for axis in axes] in (["y", "x"], ["y", ""], ["", "x"])


def is_x_or_y(axes: list) -> bool:
    """Whether at least one of two axes is marked as x or y; axes: [(name, attributes, ...)]."""
    return any(_direction(*axis[:2]) for axis in axes)


def missing_numbers(spec: Any, path: object) -> tuple[float, ...]:
    """Return the numbers of the key `missing`; texts raise SceneError (they are for text files)."""
    try:
        return tuple(float(text) for text in spec.missing)
    except ValueError:
        raise SceneError(
            f"surface.missing: found {list(spec.missing)}, but {path} is no text, allowed: numbers,"
            ' such as ["-9999"]'
        ) from None


def unit_in(attributes: Mapping[str, Any]) -> str | None:
    """Return the attribute `unit` or `units` if it is a text that is not blank, else None."""
    value = np.ravel(attributes.get("unit", attributes.get("units")))
    text = value[0] if value.size == 1 else None
    text = text.decode("utf-8", "replace") if isinstance(text, bytes) else text
    return text.strip() or None if isinstance(text, str) else None


def _direction(name: str, attributes: Mapping[str, Any]) -> str:
    """Return "x" or "y", the direction of an axis by its attributes and name; "" if unknown."""

    def text(key: str) -> str:
        value = attributes.get(key, "")
        value = value.decode("utf-8", "replace") if isinstance(value, bytes) else value
        return value.lower() if isinstance(value, str) else ""

    word = name.lower().split("_")[0]
    if text("axis") == "x" or text("standard_name") in _X_STANDARD or word in _X_NAMES:
        return "x"
    if text("axis") == "y" or text("standard_name") in _Y_STANDARD or word in _Y_NAMES:
        return "y"
    return ""


def _length(attributes: Mapping[str, Any], x: Any) -> float | None:
    """Return an axis' length, its attribute or points x times their distance (< 0 if they fall);
    None if unknown, ValueError if uneven.
    """
    if "length" in attributes:
        return float(np.ravel(attributes["length"])[0])
    if (
        x is None
        or not 2 <= len(x) <= MAX_N
        or "not a netCDF variable" in str(attributes.get("NAME"))
    ):
        return None
    points = np.asarray(x[:])
    rounding = 4 * len(x) * np.finfo(points.dtype).eps if points.dtype.kind == "f" else 0.0
    points = points.astype(np.float64)
    step = float(points[-1] - points[0]) / (len(x) - 1)
    deviation = np.abs(np.diff(points) - step).max()
    if not (step and deviation <= max(UNEVEN, rounding) * abs(step)):
        raise ValueError("its points are not those of a regular grid")
    return step * len(x)


def _are_indices(coordinates: tuple) -> bool:
    """Whether all coordinates only number the points: 0, 1, 2, ... or 1, 2, 3, ..."""
    return all(x is not None and x[0] in (0, 1) and x[1] == x[0] + 1 for x in coordinates)
