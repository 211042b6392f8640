"""Heights with their sizes, whatever file they come from: what the file says, unless the scene says
otherwise."""

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..util.errors import SceneError
from ..util.quantities import Quantity, factor
from .analytic import Rows
from .arrays import ArrayMap
from .files import HeightMap
from .heights import checked

ALIKE = 1e-6  # relative difference of lengths that are the same
UNITS = 'a unit of length, such as surface.unit = "nm"'


@dataclass(frozen=True)
class Topography:
    """n: (n_x, n_y); sizes: (L_x, L_y); rows(start, stop) -> heights, float64 (stop - start, n_y),
    nan where one is missing.

    Sizes and heights are in m where `unit` is "m", otherwise ("") in a unit that nobody named.
    periodic: True where the file says so. filled: points that had no height. plain: what a plain
    length of the scene stands for, in plain_unit, that of the sizes. source: the file. lacks:
    {key of [surface]: why it has to be given}; `prepare` refuses a Topography that lacks anything.
    """

    n: tuple[int, ...]
    sizes: tuple[float, ...]
    rows: Rows
    unit: str = ""
    periodic: bool | None = None
    path: object = None
    filled: int = 0
    plain: float = 1.0
    plain_unit: str = ""
    source: HeightMap | None = None
    lacks: dict[str, str] = field(default_factory=dict)

    def length(self, key: str, given: float) -> float:
        """A length of the scene in the unit of `sizes`. Raises SceneError where it has a unit and
        the map none."""
        if isinstance(given, Quantity) and not self.unit:
            raise SceneError(
                f"surface.{key}: found {given.text}, allowed: a plain number, as the sizes are, or"
                " surface.unit beside it"
            )
        return float(given) if isinstance(given, Quantity) else given * self.plain


def open_topography(spec: Any) -> Topography:
    """The Topography of a scene's height map, or of the sum of two, of which no height is read yet.
    Raises SceneError."""
    if isinstance(spec.path, str):
        return _open_one(spec)
    first, second = (_open_one(spec.model_copy(update={"path": path})) for path in spec.path)
    compared: tuple[Any, ...] = (
        ("points", first.n, second.n),
        ("lengths", first.sizes, second.sizes),
        ("the unit", first.unit or "none", second.unit or "none"),
    )
    for what, found, other in compared:
        same = (
            all(abs(a - b) <= ALIKE * b for a, b in zip(found, other))
            if what == "lengths"
            else found == other
        )
        if not same:
            raise SceneError(
                f"surface.path: found {what} {_shown(found)} in {first.path} and {_shown(other)} in"
                f" {second.path}, allowed: two maps of the same points, lengths and unit"
            )
    periodic = (
        None if None in (first.periodic, second.periodic) else first.periodic and second.periodic
    )
    return replace(
        first,
        rows=lambda start, stop: first.rows(start, stop) + second.rows(start, stop),
        periodic=periodic,
        path=f"{first.path} + {second.path}",
        lacks=first.lacks | second.lacks,
    )


def _shown(found: Any) -> str:
    return found if isinstance(found, str) else " x ".join(f"{length:.6g}" for length in found)


def _open_one(spec: Any) -> Topography:
    found = HeightMap(spec)
    return replace(topography_of(found, spec), source=found)


def topography_of(found: HeightMap | ArrayMap, spec: Any) -> Topography:
    """The Topography of a height map, with what a scene.File says of it. Raises SceneError."""
    said, given = found.metadata, spec.physical_sizes
    unit = spec.unit or said.unit
    sizes_unit = said.sizes_unit or unit if given is None else unit
    nothing, lacks = f"neither in the scene nor in {found.path}, allowed", {}
    if given is None and said.sizes is None:
        lacks["physical_sizes"] = (
            f"surface.physical_sizes: found nothing, {nothing}: two positive numbers [L_x, L_y],"
            ' plain in surface.unit or as "12.8 um"'
        )
    named = given is None or any(isinstance(length, Quantity) for length in given)
    if unit is None and named:
        lacks["unit"] = f"surface.unit: found nothing for the heights, {nothing}: {UNITS}"
    height = 1.0 if unit is None else _factor(unit, spec.unit, found.path)
    if spec.unit and said.unit and height != _factor(said.unit, None, found.path):
        raise SceneError(
            f"surface.unit: found {spec.unit!r}, but {found.path} has its heights in"
            f" {said.unit!r}, allowed: no surface.unit, or the file's own"
        )
    length = 1.0 if sizes_unit is None else _factor(sizes_unit, spec.unit, found.path)
    sizes = [
        size if isinstance(size, Quantity) else size * length
        for size in given or said.sizes or (1.0, 1.0)
    ]
    if not all(0 < size < float("inf") for size in sizes):
        raise SceneError(
            f"surface.physical_sizes: found {sizes} in {found.path}, allowed: two positive numbers"
            " [L_x, L_y]"
        )

    def rows(start: int, stop: int) -> np.ndarray:
        return (
            checked(
                found.rows(start, stop), start, "surface.path", f" in {found.path}", missing=True
            )
            * height
        )

    return Topography(
        (found.shape[0], found.shape[1]),
        (float(sizes[0]), float(sizes[1])),
        rows,
        "" if unit is None else "m",
        said.periodic,
        found.path,
        plain=length,
        plain_unit=sizes_unit or "",
        lacks=lacks,
    )


def _factor(unit: str, given: Any, path: str | Path) -> float:
    try:
        return factor(unit)
    except ValueError as error:
        raise SceneError(f"surface.unit: in {path} {error}, allowed: {UNITS}") from None
