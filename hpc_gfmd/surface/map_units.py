"""Sizes and units of a height map, from what its file and the scene say."""

from typing import Any

import numpy as np

from ..scene import has_unit
from ..util.errors import SceneError, SurfaceWarning
from ..util.lengths import length_factor
from ..util.quantities import Quantity, prefixed
from .metadata import Metadata

UNITS = 'a unit of length, such as surface.unit = "nm"'


class MapUnits:
    """Sizes and units of a map, from what its file and the scene say.

    Raises SceneError if scene and file give different units of the heights; different sizes only
    make a note. What neither of them says is listed in `lacks`.

    Parameters
    ----------
    metadata : Metadata
        What the file says.
    spec : scene.File
        What the scene says, which has priority.
    path : object
        Name of the map in messages.

    Attributes
    ----------
    sizes : (L_x, L_y)
        In m if units are named; (1, 1) if they are not known.
    height, length : float
        What a number of the heights in the file, and a length without a unit in the scene, is
        multiplied by to be in m; 1 if units are not named.
    sizes_unit : str, optional
        Unit of lengths without a unit in the scene; None if it is not known.
    are_named : bool
        Whether the unit of the heights is known, and with it that of the sizes.
    lacks : dict
        {key of [surface]: why it has to be given}
    notes : list of SurfaceWarning
        Remarks on the sizes for the user.
    """

    def __init__(self, metadata: Metadata, spec: Any, path: object) -> None:
        self.lacks: dict[str, str] = {}
        self.notes: list[SurfaceWarning] = []
        unit = self._height_unit(metadata, spec, path)
        scene_sizes = spec.physical_sizes
        self._require_xy_unit(metadata, spec, path)
        file_unit = metadata.sizes_unit or spec.xy_unit or unit
        in_file = metadata.sizes if file_unit is None or length_factor(file_unit) else None
        of_file = scene_sizes is None and in_file is not None
        self.sizes_unit = file_unit if of_file else spec.xy_unit or unit
        where = f"neither in the scene nor in {path}"
        if scene_sizes is None and in_file is None:
            if metadata.sizes_unit and length_factor(metadata.sizes_unit) is None:
                where = f"and in {path} in {metadata.sizes_unit!r}, which is no unit of length"
            self.lacks["physical_sizes"] = (
                f"surface.physical_sizes: not given, {where}, allowed: two positive numbers"
                ' [L_x, L_y], plain in surface.unit or as "12.8 um"'
            )
        is_needed = scene_sizes is None or has_unit(scene_sizes) or bool(spec.xy_unit)
        is_alike = of_file and not (metadata.sizes_unit or spec.xy_unit)
        if unit is None and "unit" not in self.lacks and is_needed:
            other = "; surface.xy_unit, where x and y are in another unit" * is_alike
            self.lacks["unit"] = (
                "surface.unit: not given for the heights, neither in the scene nor in"
                f" {path}, allowed: {UNITS}{other}"
            )
        self.are_named = unit is not None
        self.height = _factor(unit, path)
        self.length = _factor(self.sizes_unit, path)
        self.sizes = tuple(
            float(size if isinstance(size, Quantity) else size * self.length)
            for size in scene_sizes or in_file or (1.0, 1.0)
        )
        self._compare(metadata, spec, in_file)
        if is_alike and unit:
            text = (
                f"x and y in {path} are taken in {unit}, as the heights are (surface.xy_unit for"
                " another unit)"
            )
            self.notes.append(SurfaceWarning(text))

    def _require_xy_unit(self, metadata: Metadata, spec: Any, path: object) -> None:
        """Raise SceneError if the scene gives another unit of x and y than the file."""
        in_file = length_factor(metadata.sizes_unit or "")
        if spec.xy_unit and in_file and length_factor(spec.xy_unit) != in_file:
            raise SceneError(
                f"surface.xy_unit: found {spec.xy_unit!r}, but {path} has x and y in"
                f" {metadata.sizes_unit!r}, allowed: no surface.xy_unit, or the file's own"
            )

    def _height_unit(self, metadata: Metadata, spec: Any, path: object) -> str | None:
        """Return the unit of the heights, None if it is not known; may add to `lacks` and `notes`.

        The arguments are those of the class. Raises SceneError if scene and file contradict each
        other.
        """
        if metadata.unit is None:
            return spec.unit
        in_file = length_factor(metadata.unit)
        if in_file is None and spec.unit is None:
            self.lacks["unit"] = (
                f"surface.unit: in {path} {metadata.unit!r} is no unit of length, allowed: {UNITS}"
            )
            return None
        if in_file is None:
            text = (
                f"heights are taken in {spec.unit}, as surface.unit says; {path} says"
                f" {metadata.unit!r}"
            )
            self.notes.append(SurfaceWarning(text))
            return spec.unit
        if spec.unit is not None and length_factor(spec.unit) != in_file:
            raise SceneError(
                f"surface.unit: found {spec.unit!r}, but {path} has its heights in"
                f" {metadata.unit!r}, allowed: no surface.unit, or the file's own"
            )
        return spec.unit or metadata.unit

    def _compare(self, metadata: Metadata, spec: Any, in_file: Any) -> None:
        """Add a note if the sizes in the scene differ from those in the file by more than 0.1 %.

        in_file: (L_x, L_y), None if not given. They are not compared if only one of
        them has a unit of length.
        """
        file_unit = metadata.sizes_unit or spec.xy_unit or metadata.unit
        if file_unit and length_factor(file_unit) is None:  # heights in volts, say
            file_unit = None
        if spec.physical_sizes is None or in_file is None or (file_unit is None) == self.are_named:
            return
        sizes = [size * _factor(file_unit, "") for size in in_file]
        if not np.allclose(sizes, self.sizes, 1e-3, 0):
            text = (
                f"surface.physical_sizes are {lengths_text(self.sizes, self.are_named)}, the file"
                f" says {lengths_text(sizes, self.are_named)}"
            )
            self.notes.append(SurfaceWarning(text))


def lengths_text(sizes: Any, are_named: bool) -> str:
    """Write lengths with a common prefix of the unit.

    Parameters
    ----------
    sizes : sequence of float
        The lengths; they are read twice.
    are_named : bool
        Whether they are in m; otherwise they have no unit.

    Returns
    -------
    str
        Such as "10 um x 8 um".
    """
    scale, name = prefixed(sizes, "m" if are_named else "")
    return " x ".join(f"{size / scale:.6g} {name}".strip() for size in sizes)


def _factor(unit: str | None, path: object) -> float:
    """Return the length in m of a unit, 1 for None. Raises SceneError for other units.

    path: of the map, for the message.
    """
    if unit is None:
        return 1.0
    metres = length_factor(unit)
    if metres is None:
        raise SceneError(f"surface.unit: in {path} {unit!r} is no unit of length, allowed: {UNITS}")
    return metres
