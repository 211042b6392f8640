"""Heights with their sizes, whatever file they come from: what the file says, unless the scene says
otherwise."""

from dataclasses import dataclass, field, replace
from functools import reduce
from math import inf
from pathlib import Path
from typing import Any, Self

import numpy as np

from ..scene import each, has_unit
from ..util.errors import SceneError, one_line
from ..util.quantities import Quantity, factor
from .analytic import Rows
from .files import open_map
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

    def on_form(self, radii: tuple[float, ...]) -> Self:
        """Put the heights on the form z = -x^2/(2 R_x) - y^2/(2 R_y) about the centre of the cell;
        where both radii are inf they stay as they are."""
        R = min(radii)
        if R == inf:
            return self
        x, y = (
            ((np.arange(k) - k // 2) * (size / k)) ** 2 * (R / radius)
            for k, size, radius in zip(self.n, self.sizes, radii)
        )

        def rows(start: int, stop: int) -> np.ndarray:
            return self.rows(start, stop) - (x[start:stop, None] + y) / (2 * R)

        return replace(self, rows=rows)

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
    specs = [spec.model_copy(update={"path": path}) for path in each(spec.path)]
    return reduce(_sum, [topography_of(*open_map(one), one) for one in specs])


def _sum(one: Topography, two: Topography) -> Topography:
    if one.n != two.n or one.unit != two.unit or not np.allclose(one.sizes, two.sizes, ALIKE, 0):
        here, there = (
            f"{found.n[0]} x {found.n[1]} points, {found.sizes[0]:.6g} x {found.sizes[1]:.6g}"
            f" {found.unit or 'without a unit'} in {found.path}"
            for found in (one, two)
        )
        raise SceneError(
            f"surface.path: found {here} and {there}, allowed: two maps of the same points, lengths"
            " and unit"
        )
    return replace(
        one,
        rows=lambda start, stop: one.rows(start, stop) + two.rows(start, stop),
        periodic=one.periodic and two.periodic,
        path=f"{one.path} + {two.path}",
        lacks=one.lacks | two.lacks,
    )


def topography_of(data: Any, said: Metadata, spec: Any) -> Topography:
    """Make the Topography of a height map, with what a scene.File says of it; data: an array or
    files.FileArray, of which masked points have no height. Raises SceneError."""
    path, given = Path(spec.path), spec.physical_sizes
    unit = spec.unit or said.unit
    sizes_unit = said.sizes_unit or unit if given is None else unit
    nothing, lacks = f"neither in the scene nor in {path}, allowed", {}
    if given is None and said.sizes is None:
        lacks["physical_sizes"] = (
            f"surface.physical_sizes: not given, {nothing}: two positive numbers [L_x, L_y],"
            ' plain in surface.unit or as "12.8 um"'
        )
    if unit is None and (given is None or has_unit(given)):
        lacks["unit"] = f"surface.unit: not given for the heights, {nothing}: {UNITS}"
    height, length, own = (_factor(name, path) for name in (unit, sizes_unit, said.unit or unit))
    if height != own:
        raise SceneError(
            f"surface.unit: found {spec.unit!r}, but {path} has its heights in"
            f" {said.unit!r}, allowed: no surface.unit, or the file's own"
        )
    sizes = [
        float(size if isinstance(size, Quantity) else size * length)
        for size in given or said.sizes or (1.0, 1.0)
    ]
    if not all(0 < size < inf for size in sizes):
        raise SceneError(
            f"surface.physical_sizes: found {sizes} in {path}, allowed: two positive numbers"
            " [L_x, L_y]"
        )

    def rows(start: int, stop: int) -> np.ndarray:
        try:
            with np.errstate(over="ignore"):  # of long double; infinity is seen below
                z = data[:, start:stop].T if said.transposed else data[start:stop, :]
                z = np.asarray(np.ma.filled(np.ma.asarray(z, dtype=np.float64), np.nan))
        except Exception as error:
            raise SceneError(
                f"surface.path: reading {path} failed: {one_line(str(error))}"
            ) from None
        return height * checked(z, start, "surface.path", f" in {path}", missing=True)

    return Topography(
        data.shape[::-1] if said.transposed else data.shape,
        tuple(sizes),
        rows,
        "" if unit is None else "m",
        said.periodic,
        path,
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
