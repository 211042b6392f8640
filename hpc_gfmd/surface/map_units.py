"""Sizes and units of a height map, from what its file and the scene say."""

from typing import Any, NamedTuple

import numpy as np

from ..scene import has_unit
from ..util.errors import SceneError, SurfaceWarning
from ..util.lengths import length_factor
from ..util.quantities import Quantity, prefixed
from .metadata import Metadata

UNITS = 'a unit of length, such as surface.unit = "nm"'


class MapUnits(NamedTuple):
    """Sizes and units of a map."""

    sizes: tuple[float, ...]  # in m if units are named
    height: float  # what a number of the heights in the file is multiplied by to be in m, or 1
    length: float  # what a length without a unit in the scene is multiplied by to be in m, or 1
    sizes_unit: str | None  # unit of lengths without a unit in the scene; None if it is not known
    are_named: bool  # whether the unit of the heights is known, and with it that of the sizes
    notes: tuple[SurfaceWarning, ...]  # remarks on the sizes for the user


def missing_keys(metadata: Metadata, spec: Any, path: object) -> dict[str, str]:
    """Return {key of [surface]: why it has to be given}: what neither file nor scene says."""
    missing = {}
    unit = _height_unit(metadata, spec)
    sizes_unit = metadata.sizes_unit
    where = f"neither in the scene nor in {path}"
    if metadata.unit and unit is None:
        missing["unit"] = (
            f"surface.unit: in {path} {metadata.unit!r} is no unit of length, allowed: {UNITS}"
        )
    if spec.physical_sizes is None and _sizes_in_file(metadata, spec) is None:
        no_length = sizes_unit and length_factor(sizes_unit) is None
        wrong_unit = f"and in {path} in {sizes_unit!r}, which is no unit of length"
        missing["physical_sizes"] = (
            f"surface.physical_sizes: not given, {wrong_unit if no_length else where}, allowed: two"
            ' positive numbers [L_x, L_y], plain in surface.unit or as "12.8 um"'
        )
    is_needed = spec.physical_sizes is None or has_unit(spec.physical_sizes) or bool(spec.xy_unit)
    if unit is None and not metadata.unit and is_needed:
        hint = "; surface.xy_unit, where x and y are in another unit"
        missing["unit"] = (
            f"surface.unit: not given for the heights, {where}, allowed: {UNITS}"
            f"{hint * _are_alike(metadata, spec)}"
        )
    return missing


def units_of(metadata: Metadata, spec: Any, path: object) -> MapUnits:
    """Return sizes and units of a map. The scene has priority: other sizes make a note, other units
    raise SceneError, as does neither saying anything.
    """
    _require_the_same_units(metadata, spec, path)
    if missing := missing_keys(metadata, spec, path):
        raise SceneError("; ".join(missing.values()))
    unit = _height_unit(metadata, spec)
    in_file = _sizes_in_file(metadata, spec)
    of_file = metadata.sizes_unit or spec.xy_unit or unit
    sizes_unit = of_file if spec.physical_sizes is None else spec.xy_unit or unit
    length = _metres(sizes_unit)
    sizes = tuple(
        float(size if isinstance(size, Quantity) else size * length)
        for size in spec.physical_sizes or in_file or ()
    )
    notes = []
    if metadata.unit and length_factor(metadata.unit) is None:
        notes.append(
            f"heights are taken in {unit}, as surface.unit says; {path} says {metadata.unit!r}"
        )
    named = metadata.sizes_unit or spec.xy_unit or metadata.unit
    has_unit_in_file = length_factor(named or "") is not None
    if spec.physical_sizes and in_file and has_unit_in_file == (unit is not None):
        other_sizes = [size * _metres(named) for size in in_file]
        if not np.allclose(other_sizes, sizes, 1e-3, 0):
            notes.append(
                f"surface.physical_sizes are {lengths_text(sizes, unit is not None)}, the file says"
                f" {lengths_text(other_sizes, unit is not None)}"
            )
    if unit and _are_alike(metadata, spec):
        notes.append(
            f"x and y in {path} are taken in {unit}, as the heights are (surface.xy_unit for"
            " another unit)"
        )
    remarks = tuple(map(SurfaceWarning, notes))
    return MapUnits(sizes, _metres(unit), length, sizes_unit, unit is not None, remarks)


def _height_unit(metadata: Metadata, spec: Any) -> str | None:
    """Return the unit of the heights; None if it is not known, or none of length."""
    is_length = metadata.unit is not None and length_factor(metadata.unit) is not None
    return spec.unit or (metadata.unit if is_length else None)


def _sizes_in_file(metadata: Metadata, spec: Any) -> tuple[float, ...] | None:
    """Return the sizes that the file says; None if they are in no unit of length."""
    unit = metadata.sizes_unit or spec.xy_unit or _height_unit(metadata, spec)
    return metadata.sizes if unit is None or length_factor(unit) else None


def _are_alike(metadata: Metadata, spec: Any) -> bool:
    """Whether the sizes of the file are taken in the unit of the heights."""
    has_own_unit = metadata.sizes_unit or spec.xy_unit
    is_of_file = spec.physical_sizes is None and _sizes_in_file(metadata, spec) is not None
    return is_of_file and not has_own_unit


def _require_the_same_units(metadata: Metadata, spec: Any, path: object) -> None:
    """Raise SceneError if the scene gives other units than the file."""
    for key, numbers, in_scene, in_file in (
        ("unit", "its heights", spec.unit, metadata.unit),
        ("xy_unit", "x and y", spec.xy_unit, metadata.sizes_unit),
    ):
        metres = length_factor(in_file or "")
        if in_scene and metres and length_factor(in_scene) != metres:
            raise SceneError(
                f"surface.{key}: found {in_scene!r}, but {path} has {numbers} in {in_file!r},"
                f" allowed: no surface.{key}, or the file's own"
            )


def lengths_text(sizes: Any, are_named: bool) -> str:
    """Write lengths with a common prefix, as "10 um x 8 um"; `are_named`: in m, else unitless."""
    scale, name = prefixed(sizes, "m" if are_named else "")
    return " x ".join(f"{size / scale:.6g} {name}".strip() for size in sizes)


def _metres(unit: str | None) -> float:
    return 1.0 if unit is None else length_factor(unit) or 1.0
