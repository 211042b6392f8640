"""Heights with their sizes, whatever file they come from: what the file says, unless the scene says
otherwise."""

from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np

from ..scene import has_unit
from ..util.errors import SceneError
from ..util.quantities import Quantity, factor
from .analytic import Rows
from .files import HeightMap, open_map
from .heights import checked
from .metadata import Metadata

ALIKE = 1e-6  # relative difference of lengths that are the same
UNITS = 'a unit of length, such as surface.unit = "nm"'


@dataclass(frozen=True)
class Topography:
    """n: (n_x, n_y); sizes: (L_x, L_y); rows(start, stop) -> heights, float64 (stop - start, n_y),
    nan where one is missing.

    Sizes and heights are in m where `unit` is "m", otherwise ("") in a unit that nobody named.
    periodic: True where the file says so. filled: points that had no height. plain: what a plain
    length of the scene stands for, in plain_unit, that of the sizes. said: by the file itself.
    lacks: {key of [surface]: why it has to be given}; `prepare` refuses a Topography that lacks
    anything. done: to the heights, notes: what to know of them, a line each.
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
    said: Metadata = field(default_factory=Metadata)
    lacks: dict[str, str] = field(default_factory=dict)
    done: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    def after(self, done: str, **changed: Any) -> Self:
        """Return the Topography changed, with one line more of what has been done to its
        heights."""
        return replace(self, done=(*self.done, done), **changed)

    def length(self, key: str, given: float) -> float:
        """Return a length of the scene in the unit of `sizes`. Raises SceneError where it has a
        unit and the map none."""
        if isinstance(given, Quantity) and not self.unit:
            raise SceneError(
                f"surface.{key}: found {given.text}, allowed: a plain number, as the sizes are, or"
                " surface.unit beside it"
            )
        return float(given) if isinstance(given, Quantity) else given * self.plain


def open_topography(spec: Any) -> Topography:
    """Open the Topography of a scene's height map, or of the sum of two, of which no height is read
    yet. Raises SceneError."""
    paths = [spec.path] if isinstance(spec.path, str) else spec.path
    files = [open_map(spec.model_copy(update={"path": path})) for path in paths]
    first, *others = (topography_of(file, spec) for file in files)
    return _sum(first, *others) if others else first


def _sum(one: Topography, two: Topography) -> Topography:
    for what, *found, same in (
        ("points", one.n, two.n, one.n == two.n),
        ("lengths", one.sizes, two.sizes, np.allclose(one.sizes, two.sizes, ALIKE, 0)),
        ("the unit", [one.unit or "none"], [two.unit or "none"], one.unit == two.unit),
    ):
        if not same:
            here, there = (
                " x ".join(f"{of:.6g}" if isinstance(of, float) else str(of) for of in shown)
                for shown in found
            )
            raise SceneError(
                f"surface.path: found {what} {here} in {one.path} and {there} in {two.path},"
                " allowed: two maps of the same points, lengths and unit"
            )
    return replace(
        one,
        rows=lambda start, stop: one.rows(start, stop) + two.rows(start, stop),
        periodic=one.periodic and two.periodic,
        path=f"{one.path} + {two.path}",
        lacks=one.lacks | two.lacks,
    )


def topography_of(found: HeightMap, spec: Any) -> Topography:
    """Make the Topography of a height map, with what a scene.File says of it. Raises SceneError."""
    said, given = found.metadata, spec.physical_sizes
    unit = spec.unit or said.unit
    sizes_unit = said.sizes_unit or unit if given is None else unit
    nothing, lacks = f"neither in the scene nor in {found.path}, allowed", {}
    if given is None and said.sizes is None:
        lacks["physical_sizes"] = (
            f"surface.physical_sizes: not given, {nothing}: two positive numbers [L_x, L_y],"
            ' plain in surface.unit or as "12.8 um"'
        )
    if unit is None and (given is None or has_unit(given)):
        lacks["unit"] = f"surface.unit: not given for the heights, {nothing}: {UNITS}"
    height, length, own = (
        _factor(name, found.path) for name in (unit, sizes_unit, said.unit or unit)
    )
    if height != own:
        raise SceneError(
            f"surface.unit: found {spec.unit!r}, but {found.path} has its heights in"
            f" {said.unit!r}, allowed: no surface.unit, or the file's own"
        )
    sizes = [
        float(size) if isinstance(size, Quantity) else float(size * length)
        for size in given or said.sizes or (1.0, 1.0)
    ]
    if not all(0 < size < float("inf") for size in sizes):
        raise SceneError(
            f"surface.physical_sizes: found {sizes} in {found.path}, allowed: two positive numbers"
            " [L_x, L_y]"
        )

    def rows(start: int, stop: int) -> np.ndarray:
        where = "surface.path", f" in {found.path}"
        return height * checked(found.rows(start, stop), start, *where, missing=True)

    return Topography(
        (found.shape[0], found.shape[1]),
        (sizes[0], sizes[1]),
        rows,
        "" if unit is None else "m",
        said.periodic,
        found.path,
        plain=length,
        plain_unit=sizes_unit or "",
        said=said,
        lacks=lacks,
    )


def _factor(unit: str | None, path: object) -> float:
    try:
        return 1.0 if unit is None else factor(unit)
    except ValueError as error:
        raise SceneError(f"surface.unit: in {path} {error}, allowed: {UNITS}") from None
