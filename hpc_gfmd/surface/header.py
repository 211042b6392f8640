"""The lines before the numbers of a text: names and units of columns, headers of instruments."""

import re
from collections.abc import Iterable
from contextlib import suppress
from io import BytesIO
from typing import NamedTuple

import numpy as np

from ..util.lengths import length_factor
from ..util.libraries import surface_topography
from .metadata import Metadata

_COLUMN = re.compile(r"([^\W\d_]\w*)\s*(?:[\[(]\s*([^\])]*?)\s*[\])])?")
_IN_BRACKETS = re.compile(r"[\[(]\s*([^\d\W_]+)\s*[\])]")
_ROLES = (r"x\d?|x[_ ].*", r"y\d?|y[_ ].*", r"z\d?|z[_ ].*|heights?|h|topography")
_GWYDDION_UNIT = re.compile(r"(?P<key>Lateral|Value) units:\s*(?P<unit>\S+)", re.I)
_NO_DATA = re.compile(
    r"\b(?:no_?data(?:_value)?|_?fill_?value|missing_value)\b\s*[:=]?\s*(\S+)", re.I
)
_ESRI = re.compile(r"\s*(ncols|nrows|cellsize|dx|dy)\s+(\S+)\s*", re.I)
_PIXELS = re.compile(r"(?<=\d)\s*(?:px|pixels?)\s*$", re.I | re.M)
_ROW = "<row>"  # stands for a line of numbers


class Columns(NamedTuple):
    """Places and units of x, y and z in a text (units None unless all are named); other names."""

    places: tuple[int, ...]
    units: tuple[str, ...] | None
    unused: tuple[str, ...]


def columns_named(header: list[str], mark: str | None, columns: int) -> Columns | None:
    """Find x, y and z by their names in one of the last three lines of a header, which must have as
    many fields as there are columns.
    """
    titles = [line.strip().lstrip("#%;/ \t").strip() for line in header if line.strip()][-3:]
    for title in reversed(titles):
        if mark and mark in title:
            fields = [_COLUMN.match(field.strip(' "')) for field in title.split(mark)]
            named = [("", "") if field is None else field.groups("") for field in fields]
        else:
            named = _COLUMN.findall(title)
        if len(named) != columns:
            continue
        roles = [
            [k for k, (name, _) in enumerate(named) if re.fullmatch(role, name.lower())]
            for role in _ROLES
        ]
        if all(len(role) == 1 for role in roles):
            places = tuple(role[0] for role in roles)
            unused_places = [k for k in range(columns) if k not in places]
            unused = tuple(named[k][0] or f"column {k + 1}" for k in unused_places)
            units = tuple(named[k][1] for k in places)
            return Columns(places, units if all(units) else units_of(titles), unused)
    return None


def units_of(header: list[str]) -> tuple[str, ...] | None:
    """Return the units of x, y and z in a header, or None: texts in brackets in one of its last two
    lines that are not blank, or Gwyddion's.
    """
    named = {
        match["key"].lower(): match["unit"] for match in _GWYDDION_UNIT.finditer("".join(header))
    }
    if len(named) == 2:
        return named["lateral"], named["lateral"], named["value"]
    for line in reversed([line for line in header if line.strip()][-2:]):
        units = _IN_BRACKETS.findall(line)
        if len(units) >= 3:
            return tuple(units[:3])
    return None


def missing_numbers(header: list[str]) -> tuple[float, ...]:
    """Return the numbers that a header declares to mark missing points, such as NODATA_value."""
    return numbers_in(_NO_DATA.findall("\n".join(header)))


def numbers_in(texts: Iterable[str]) -> tuple[float, ...]:
    """Return the numbers among some texts."""
    numbers = []
    for text in texts:
        with suppress(ValueError):
            numbers.append(float(text))
    return tuple(numbers)


def of_esri(header: list[str], table: np.ndarray) -> tuple[np.ndarray, Metadata] | None:
    """Return heights (n_y, n_x) and metadata (sizes without a unit) of an ESRI grid, or None."""
    of_header = {
        match[1].lower(): float(match[2].replace(",", "."))
        for match in map(_ESRI.fullmatch, header)
        if match
    }
    if not {"nrows", "ncols"} <= of_header.keys():
        return None
    n_x, n_y = int(of_header["ncols"]), int(of_header["nrows"])
    if table.shape != (n_y, n_x) and table.shape != (1, n_x * n_y):  # a grid may be one long line
        raise ValueError(
            f"found {table.shape[0]} lines of {table.shape[1]} numbers, allowed: {n_y} of {n_x}, as"
            " its header says"
        )
    step_x, step_y = (of_header.get(name, of_header.get("cellsize")) for name in ("dx", "dy"))
    sizes = None if step_x is None or step_y is None else (n_x * step_x, n_y * step_y)
    direction = "along a line of the text, as its header says"
    return table.reshape(n_y, n_x), Metadata(sizes, transposed=True, direction=direction)


def of_instrument(header: list[str], lines: int, columns: int) -> tuple[Metadata, float] | None:
    """Return metadata and the factor to heights by SurfaceTopography's header readers, None for
    another kind; ValueError for other quantities than heights or other numbers of lines or columns.
    """
    if not any(re.search(r"[^\W\d_]{2}", line) for line in header):
        return None
    surface_topography()
    from SurfaceTopography.Exceptions import CorruptFile
    from SurfaceTopography.IO.Text import AscReader

    row = [0.0] * columns

    class HeaderReader(AscReader):  # type: ignore[misc]  # it has no types
        """A reader that gets placeholders for lines of numbers, so that it sees no number."""

        def parse_data(self, line: str) -> list[float]:
            if line.strip() == _ROW:
                return row
            raise ValueError

    text = "".join(line.rstrip("\r\n") + "\n" for line in header)
    in_pixels = bool(_PIXELS.search(text))
    text = _PIXELS.sub(" m", text)
    try:
        channel = HeaderReader(BytesIO((text + f"{_ROW}\n" * lines).encode())).channels[0]
    except CorruptFile as error:
        if "line scan" in str(error):
            return None
        raise ValueError(f"its header does not fit: {error}; surface.skip_lines skips it") from None
    sizes = channel.physical_sizes
    if channel.dim != 2 or (sizes is not None and len(sizes) != 2):
        return None
    if sizes is None and channel.unit is None and channel.height_scale_factor is None:
        return None
    return (
        Metadata(
            sizes=None if in_pixels or sizes is None else tuple(map(float, sizes)),
            sizes_unit="px" if in_pixels else channel.unit,
            unit=channel.unit,
            transposed=True,
            direction="along a line of the text, as its header says",
            channel="" if channel.name == "Default" else channel.name,
        ),
        1.0 if channel.height_scale_factor is None else float(channel.height_scale_factor),
    )


def unit_in_brackets(text: str) -> str | None:
    """Return a text if it is a unit of length, else the first one in brackets in it, or None."""
    units = [text.strip(), *_IN_BRACKETS.findall(text)]
    return next((unit for unit in units if unit and length_factor(unit)), None)
