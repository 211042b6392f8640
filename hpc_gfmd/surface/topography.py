"""Heights with their sizes from any file; what the scene says has priority."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import reduce
from math import inf
from pathlib import Path
from typing import Any, Self

import numpy as np

from ..scene import each
from ..scene.height_maps import Reading
from ..util.errors import (
    ReadingWarning,
    SceneError,
    SurfaceWarning,
    each_once,
    is_mistake,
    one_line,
)
from ..util.quantities import Quantity
from .doubtful_numbers import stand_in_notes
from .files import open_map
from .heights import Rows, StoredRows, collected, require_finite
from .map_units import MapUnits, lengths_text, units_of
from .metadata import Metadata
from .surface import MIRRORED
from .two_scans import ALIKE, combined, placed

SQUARE = 0.01  # relative difference of spacings of square points, at most
OBLONG = 0.05  # of points that are not square, at least
# Numbers in double precision per point that a reader holds beside the bytes of its file, and then
# without them.
NUMBERS = {"text": (1.4, 2.0), "x, y, z": (3.6, 9.2)}
OTHER_NUMBERS = (2.1, 2.1)
SIZES = 1e-9, 1.0  # m: no instrument measures less, or more


@dataclass(frozen=True)
class Topography:
    """Heights that can be read by rows, with their sizes and units."""

    n: tuple[int, ...]
    # (L_x, L_y), in m if `unit` is "m"
    sizes: tuple[float, ...]
    # rows(start, stop) reads heights: float64, (stop - start, n_y), nan where one is missing. Peaks
    # are up; x and y rise.
    rows: Rows
    # "m", or "" if sizes and heights have no unit
    unit: str = ""
    # True if the file says so; None if it is not known
    periodic: bool | None = None
    # of the file, for messages
    path: object = None
    # number of points that had no height and were filled
    filled: int = 0
    # takes a length without a unit in the scene to the unit of `sizes`
    plain: float = 1.0
    # unit of such lengths, "" if it is not known
    plain_unit: str = ""
    # Position of the first point, in the unit of `sizes`; only used to place two scans.
    origin: tuple[float, float] = (0.0, 0.0)
    # the two scans of which it is the sum, see `combined`
    bodies: "tuple[Topography, ...]" = ()
    # what the file says
    metadata: Metadata = field(default_factory=Metadata)
    # bytes that reading the file took at most, and of what is left in memory; 0 where `rows` reads
    # from the file no more than these rows
    reading: float = 0.0
    stored: int = 0
    # what was done to the heights, a line each
    prepared: tuple[str, ...] = ()
    # remarks for the user; a ReadingWarning says how the heights were read
    notes: tuple[SurfaceWarning, ...] = ()

    def heights(self) -> np.ndarray:
        """Return all heights, shape n; they must not be changed."""
        return collected(self.rows, 0, *self.n)

    def of_heights(self, z: np.ndarray, step: str, **changes: Any) -> Self:
        """Return a copy with other heights after a step of preparation, see `after`."""
        return self.after(step, n=z.shape, rows=StoredRows(z), **changes)

    def after(self, step: str, **changes: Any) -> Self:
        """Return a copy with changes by a step of preparation, a line for `prepared`."""
        return replace(self, prepared=(*self.prepared, step), **changes)

    def on_form(self, radii: tuple[float, ...], at_a_point: bool = False) -> Self:
        """Return a copy on the paraboloid z = -x^2/(2 R_x) - y^2/(2 R_y) about the centre, which
        lies between points of an even number, or `at_a_point`, (n_x // 2, n_y // 2); radii in the
        unit of `sizes`, inf is straight.
        """
        R = min(radii)
        if R == inf:
            return self
        x, y = (
            ((np.arange(k) - (k // 2 if at_a_point else (k - 1) / 2)) * (size / k)) ** 2
            * (R / radius)
            for k, size, radius in zip(self.n, self.sizes, radii)
        )

        def rows(start: int, stop: int) -> np.ndarray:
            return self.rows(start, stop) - (x[start:stop, None] + y) / (2 * R)

        return replace(self, rows=rows)

    def mirrored(self, along: tuple[bool, bool]) -> Self:
        """Return a copy with its mirror images: twice as long along the chosen axes."""
        if not any(along):
            return self
        n_x, n_y = self.n
        copies = [2 if axis else 1 for axis in along]
        n = (n_x * copies[0], n_y * copies[1])

        def rows(start: int, stop: int) -> np.ndarray:
            z = np.empty((stop - start, n[1]))
            middle = min(max(n_x - start, 0), stop - start)  # rows before it are those of the map
            straight = self.rows(min(start, n_x), min(stop, n_x))
            turned = self.rows(2 * n_x - max(stop, n_x), 2 * n_x - max(start, n_x))[::-1]
            for part, of_map in ((z[:middle], straight), (z[middle:], turned)):
                part[:, :n_y] = of_map
                part[:, n_y:] = of_map[:, ::-1] if along[1] else 0
            return z

        return self.after(
            MIRRORED[along],
            n=n,
            sizes=tuple(size * copy for size, copy in zip(self.sizes, copies)),
            rows=rows,
            periodic=True if all(along) else self.periodic,
        )

    def length(self, key: str, value: float) -> float:
        """Convert a length of the scene to the unit of `sizes`; SceneError if only it has one."""
        if isinstance(value, Quantity) and not self.unit:
            raise SceneError(
                f"surface.{key}: found {value.text}, allowed: a plain number, as the sizes are, or"
                " surface.unit beside it"
            )
        return float(value) if isinstance(value, Quantity) else value * self.plain


def open_topography(spec: Any) -> Topography:
    """Open the map of a scene, or the sum of two; heights are read later, by `rows`."""
    if spec.bodies:
        scans = [topography_of(*open_map(body), body) for body in specs_of_bodies(spec)]
        return sum_of_bodies(scans, spec)
    specs = [spec.model_copy(update={"path": path}) for path in each(spec.path)]
    return reduce(_sum, [topography_of(*open_map(one_map), one_map) for one_map in specs])


def sum_of_bodies(scans: Sequence[Topography], spec: Any) -> Topography:
    """Return the sum of two scans, unread."""
    sum_of_two: Topography = combined(placed((scans[0], scans[1]), spec), spec)
    return sum_of_two


def specs_of_bodies(spec: Any) -> list[Any]:
    """Return what a scene says of each of two scans: the keys of [surface] for those it lacks."""
    specs = []
    for body in spec.bodies:
        keys = {key: getattr(body, key) for key in Reading.model_fields}
        of_body = {key: value for key, value in keys.items() if value is not None}
        specs.append(spec.model_copy(update=of_body | {"bodies": None}))
    return specs


def topography_of(data: Any, metadata: Metadata, spec: Any) -> Topography:
    """Make the Topography of a map with what a scene says of it; its `rows` raise SceneError if
    reading fails or heights are too large.
    """
    path = Path(spec.path)
    metadata = _with_first_axis(metadata, spec)
    units = units_of(metadata, spec, path)
    if not all(0 < size < inf for size in units.sizes):
        raise SceneError(
            f"surface.physical_sizes: found {list(units.sizes)} in {path}, allowed: two positive"
            " numbers [L_x, L_y]"
        )
    n = data.shape[::-1] if metadata.transposed else data.shape

    def rows(start: int, stop: int) -> np.ndarray:
        try:
            with np.errstate(over="ignore"):  # of long double; infinity is seen below
                z = _rows_of(data, metadata, start, stop, n[0])
        except Exception as error:
            if is_mistake(error):
                raise
            raise SceneError(
                f"surface.path: reading {path} failed: {one_line(str(error))}"
            ) from None
        require_finite(z, start, "surface.path", f" in {path}", missing=True)
        return units.height * z

    is_read = isinstance(data, np.ndarray) and not isinstance(data, np.memmap)
    notes = (*_notes_on_reading(metadata, spec, n), *units.notes, *_notes_on_sizes(n, units))
    if is_read and spec.height_range is None:  # else numbers of the file are not heights yet
        notes += tuple(stand_in_notes(data, metadata.missing))
    return Topography(
        n,
        units.sizes,
        rows,
        "m" if units.are_named else "",
        metadata.periodic,
        path,
        plain=units.length,
        plain_unit=units.sizes_unit or "",
        metadata=metadata,
        reading=_bytes_of_reading(metadata, data.size) if is_read else 0.0,
        stored=data.nbytes if is_read else 0,
        notes=notes,
    )


def _bytes_of_reading(metadata: Metadata, points: int) -> float:
    """Return how many bytes reading a map whole takes at most."""
    beside_file, at_the_end = NUMBERS.get(metadata.reader, OTHER_NUMBERS)
    return max(metadata.file_bytes + 8 * beside_file * points, 8 * at_the_end * points)


def _sum(lower: Topography, upper: Topography) -> Topography:
    """Return the sum of two maps of equal points, lengths and unit, with metadata of `lower`."""
    if (
        lower.n != upper.n
        or lower.unit != upper.unit
        or not np.allclose(lower.sizes, upper.sizes, ALIKE, 0)
    ):
        texts = [
            f"{topography.n[0]} x {topography.n[1]} points, {topography.sizes[0]:.6g} x"
            f" {topography.sizes[1]:.6g} {topography.unit or 'without a unit'} in {topography.path}"
            for topography in (lower, upper)
        ]
        raise SceneError(
            f"surface.path: found {texts[0]} and {texts[1]}, allowed: two maps of the same points,"
            " lengths and unit (others: surface.bodies)"
        )
    return replace(
        lower,
        rows=lambda start, stop: lower.rows(start, stop) + upper.rows(start, stop),
        periodic=lower.periodic and upper.periodic,
        path=f"{lower.path} + {upper.path}",
        notes=each_once([*lower.notes, *upper.notes]),
        reading=max(lower.reading, lower.stored + upper.reading),
        stored=lower.stored + upper.stored,
    )


def _with_first_axis(metadata: Metadata, spec: Any) -> Metadata:
    """Return metadata with the scene's first_axis; axes are exchanged if the file's x differs."""
    if spec.first_axis is None:
        return metadata
    transposed = spec.first_axis == "y"
    with_direction = replace(
        metadata, direction=f"as surface.first_axis = {spec.first_axis!r} says"
    )
    if transposed == metadata.transposed:
        return replace(with_direction, direction_known=True)
    return replace(
        with_direction,
        transposed=transposed,
        direction_known=True,
        sizes=metadata.sizes and metadata.sizes[::-1],
        falling=metadata.falling[::-1],
    )


def _rows_of(data: Any, metadata: Metadata, start: int, stop: int, n_x: int) -> np.ndarray:
    """Read rows start <= i < stop of heights: float64, x and y rising, nan where missing."""
    begin, end = (n_x - stop, n_x - start) if metadata.falling[0] else (start, stop)
    z = data[:, begin:end].T if metadata.transposed else data[begin:end, :]
    z = np.asarray(np.ma.filled(np.ma.asarray(z, dtype=np.float64), np.nan))
    if metadata.falling[0]:
        z = z[::-1]
    if metadata.falling[1]:
        z = z[:, ::-1]
    if metadata.missing:
        z = np.where(np.isin(z, metadata.missing), np.nan, z)
    return z


def _notes_on_reading(
    metadata: Metadata, spec: Any, n: tuple[int, ...]
) -> Iterator[ReadingWarning]:
    """Yield notes on how a file was read: remarks, which channel, x of unknown direction."""
    for remark in metadata.remarks:
        yield ReadingWarning(f"{spec.path}: {remark}")
    if metadata.other_channels and spec.dataset != metadata.channel:
        other_names = one_line(", ".join(metadata.other_channels))
        yield ReadingWarning(
            f"channel {metadata.channel!r} of {spec.path} is pressed; others: {other_names}"
        )
    if not metadata.direction_known and n[0] != n[1]:
        yield ReadingWarning(
            f'x runs {metadata.direction} {spec.path} (surface.first_axis = "y" says that y does)'
        )


def _notes_on_sizes(n: tuple[int, ...], units: MapUnits) -> Iterator[SurfaceWarning]:
    """Yield notes on sizes that seem to be exchanged or in a wrong unit."""
    spacings = [size / k for size, k in zip(units.sizes, n)]
    exchanged = [size / k for size, k in zip(units.sizes[::-1], n)]
    is_oblong = abs(np.log(spacings[0] / spacings[1])) > OBLONG
    if min(n) > 1 and is_oblong and abs(np.log(exchanged[0] / exchanged[1])) < SQUARE:
        yield SurfaceWarning(
            f"points are {lengths_text(spacings, units.are_named)}; they would be square with"
            ' exchanged sizes: are x and y meant the other way round? (surface.first_axis = "y"'
            " takes the first index of the map, or the line of a text, for y)"
        )
    shortest, longest = SIZES
    if units.are_named and not shortest <= min(units.sizes) <= max(units.sizes) <= longest:
        yield SurfaceWarning(
            f"the map is {lengths_text(units.sizes, True)}, which no instrument measures: is the"
            " unit right?"
        )
