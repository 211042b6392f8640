"""What a file says about its heights beside them: sizes, units, whether they are periodic."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

UNEVEN = 1e-3  # of a step: coordinates that differ by more are not those of a grid


@dataclass(frozen=True)
class Metadata:
    """sizes: (L_x, L_y), in sizes_unit; unit: of the heights; periodic: True where the file says
    so. None: the file does not say.

    transposed: the first axis of the array is y.
    """

    sizes: tuple[float, ...] | None = None
    sizes_unit: str | None = None
    unit: str | None = None
    periodic: bool | None = None
    transposed: bool = False


Map = tuple[Any, Metadata]  # an array, or what is sliced as one, and what is said of it
NAMES = ("physical_sizes", "unit", "units", "periodic")


def by_attributes(*places: Mapping[str, Any]) -> Metadata:
    """Read attributes physical_sizes, unit or units, and periodic, each in the first of these
    dictionaries that has it (HDF5, .npz). Sizes are in the unit beside them, or else in that of the
    heights."""

    def first(name: str) -> Mapping[str, Any]:
        return next((place for place in places if name in place), {})

    sized, unit = first("physical_sizes"), next(filter(None, map(_unit, places)), None)
    sizes = np.ravel(sized.get("physical_sizes", ())).astype(float)
    periodic = bool(np.all(first("periodic").get("periodic", False)))
    return Metadata(
        tuple(sizes.tolist()) if len(sizes) == 2 else None,
        _unit(sized) or unit,
        unit,
        periodic or None,
    )


def by_axes(heights: Mapping[str, Any], axes: list) -> Metadata:
    """Read what a NetCDF variable's attributes say, and its axes [(name, attributes, coordinates of
    its points or None), ...].

    Both conventions hold: `length` and `unit` of the axes (SurfaceTopography), coordinates of the
    points and `units` (CF).
    """
    transposed = [name.lower() for name, *_ in axes] == ["y", "x"]
    _, attributes, coordinates = zip(*(axes[::-1] if transposed else axes))
    known = [found for found in map(_length, attributes, coordinates) if found is not None]
    sizes, units = tuple(known) if len(known) == 2 else None, [*map(_unit, attributes)]
    if sizes and units[0] != units[1]:
        raise ValueError(f"its axes are in different units, {units[0]} and {units[1]}")
    unit = _unit(heights) or (units[0] if all("length" in axis for axis in attributes) else None)
    periodic = all(np.all(axis.get("periodic", False)) for axis in attributes)
    return Metadata(sizes, units[0], unit, periodic or None, transposed)


def _length(attributes: Mapping[str, Any], x: Any) -> float | None:
    """Return the length of an axis, None where it is not known, as of a NetCDF 4 dimension without
    coordinates; of its coordinates x only the first two and the last two are read."""
    if "length" in attributes:
        return float(np.ravel(attributes["length"])[0])
    if x is None or len(x) < 2 or "not a netCDF variable" in str(attributes.get("NAME")):
        return None
    first, second, other, last = (float(x[k]) for k in (0, 1, -2, -1))
    step = (last - first) / (len(x) - 1)
    even = (abs(one - step) <= UNEVEN * abs(step) for one in (second - first, last - other))
    if not (step and all(even)):
        raise ValueError("its points are not those of a regular grid")
    return abs(step) * len(x)


def _unit(attributes: Mapping[str, Any]) -> str | None:
    found = np.ravel(attributes.get("unit", attributes.get("units")))
    text = found[0] if found.size == 1 else None
    text = text.decode("utf-8", "replace") if isinstance(text, bytes) else text
    return text.strip() or None if isinstance(text, str) else None
