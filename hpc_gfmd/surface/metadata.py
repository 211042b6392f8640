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


NAMES = ("physical_sizes", "unit", "units", "periodic")


def by_attributes(*places: Mapping[str, Any]) -> Metadata:
    """Read attributes physical_sizes, unit or units, and periodic, each in the first of these
    dictionaries that has it (HDF5, .npz). Sizes are in the unit beside them, or else in that of the
    heights."""

    def first(name: str) -> Mapping[str, Any]:
        return next((place for place in places if name in place), {})

    sized, unit = first("physical_sizes"), next(filter(None, map(_unit, places)), None)
    sizes = np.asarray(sized.get("physical_sizes", ()), dtype=float).reshape(-1)
    periodic = bool(np.all(first("periodic").get("periodic", False)))
    return Metadata(
        tuple(map(float, sizes)) if len(sizes) == 2 else None,
        _unit(sized) or unit,
        unit,
        periodic or None,
    )


def by_axes(heights: Mapping[str, Any], axes: list) -> Metadata:
    """Read what a NetCDF variable's attributes say, and its axes [(name, attributes, `ends` of its
    coordinates or None, points), ...].

    Both conventions hold: `length` and `unit` of the axes (SurfaceTopography), coordinates of the
    points and `units` (CF).
    """
    transposed = [name.lower() for name, *_ in axes] == ["y", "x"]
    axes = axes[::-1] if transposed else axes
    known = [length for axis in axes if (length := _length(*axis[1:])) is not None]
    units = [_unit(attributes) for _, attributes, *_ in axes]
    if units[0] != units[1]:
        raise ValueError(f"its axes are in different units, {units[0]} and {units[1]}")
    unit = _unit(heights) or (
        units[0] if all("length" in attributes for _, attributes, *_ in axes) else None
    )
    periodic = all(np.all(attributes.get("periodic", False)) for _, attributes, *_ in axes)
    return Metadata(
        tuple(known) if len(known) == 2 else None, units[0], unit, periodic or None, transposed
    )


def _length(attributes: Mapping[str, Any], x: np.ndarray | None, n: int) -> float | None:
    if "length" in attributes:
        return float(np.asarray(attributes["length"]).reshape(-1)[0])
    if x is None or n < 2:
        return None
    step = (x[-1] - x[0]) / (n - 1)
    if not np.all(np.abs(np.diff(x)[[0, -1]] - step) <= UNEVEN * abs(step)) or not step:
        raise ValueError("its points are not those of a regular grid")
    return float(abs(step) * n)


def ends(coordinates: Any) -> np.ndarray:
    """Return the first two and the last two of any number of coordinates, at least two."""
    return np.concatenate(
        [np.asarray(coordinates[k], dtype=float) for k in (slice(2), slice(-2, None))]
    )


def _unit(attributes: Mapping[str, Any]) -> str | None:
    found = np.asarray(attributes.get("unit", attributes.get("units"))).reshape(-1)
    text = found[0] if found.size == 1 else None
    text = text.decode("utf-8", "replace") if isinstance(text, bytes) else text
    return text.strip() or None if isinstance(text, str) else None
