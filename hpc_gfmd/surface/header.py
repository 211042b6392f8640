"""The lines before the numbers of a text: names and units of columns, headers of instruments."""

import re
from dataclasses import dataclass
from io import BytesIO

import numpy as np

from ..util.lengths import length_factor
from ..util.libraries import surface_topography
from .metadata import Metadata

_COLUMN = re.compile(r"([^\W\d_]\w*)\s*(?:[\[(]\s*([^\])]*?)\s*[\])])?")
_IN_BRACKETS = re.compile(r"[\[(]\s*([^\d\W_]+)\s*[\])]")
_ROLES = {"x": r"x\d?|x[_ ].*", "y": r"y\d?|y[_ ].*", "z": r"z\d?|z[_ ].*|heights?|h|topography"}
_GWYDDION_UNIT = re.compile(r"(?P<key>Lateral|Value) units:\s*(?P<unit>\S+)", re.I)
_NO_DATA = re.compile(
    r"\b(?:no_?data(?:_value)?|_?fill_?value|missing_value)\b\s*[:=]?\s*(\S+)", re.I
)
_ESRI = re.compile(r"\s*(ncols|nrows|cellsize|dx|dy)\s+(\S+)\s*", re.I)
_PIXELS = re.compile(r"(?<=\d)\s*(?:px|pixels?)\s*$", re.I | re.M)
_ROW = "<row>"  # stands for a line of numbers


@dataclass(frozen=True)
class Columns:
    """Where the columns x, y and z of a text are.

    Attributes
    ----------
    places : (int, int, int)
        Indices of the columns x, y and z, from 0.
    units : (str, str, str), optional
        Units of x, y and z; None unless all three are named.
    unused : tuple of str
        Names of all other columns.
    """

    places: tuple[int, ...]
    units: tuple[str, ...] | None
    unused: tuple[str, ...]


def columns_named(header: list[str], mark: str | None, columns: int) -> Columns | None:
    """Find the columns x, y and z by the names in a header.

    Parameters
    ----------
    header : list of str
        Lines before the numbers; only the last three that are not blank are searched.
    mark : str or None
        What separates numbers; None: white space.
    columns : int
        Numbers in a line.

    Returns
    -------
    Columns or None
        None unless a line has as many fields as there are columns, and exactly one of them names
        each of x, y and z.
    """
    titles = [line.strip().lstrip("#%;/ \t").strip() for line in header if line.strip()][-3:]
    for title in reversed(titles):
        fields = title.split(mark) if mark and mark in title else _COLUMN.findall(title)
        matches = [
            _COLUMN.match(field.strip(' "')) if isinstance(field, str) else field
            for field in fields
        ]
        named = [
            ("", "") if match is None else match if isinstance(match, tuple) else match.groups("")
            for match in matches
        ]
        if len(named) != columns:
            continue
        names = [name.lower() for name, _ in named]
        places = [
            [k for k, name in enumerate(names) if re.fullmatch(pattern, name)]
            for pattern in _ROLES.values()
        ]
        if all(len(place) == 1 for place in places):
            chosen = tuple(place[0] for place in places)
            unused = tuple(
                named[k][0] or f"column {k + 1}" for k in range(columns) if k not in chosen
            )
            units = tuple(named[k][1] for k in chosen)
            return Columns(chosen, units if all(units) else units_of(titles), unused)
    return None


def units_of(header: list[str]) -> tuple[str, ...] | None:
    """Return the units of x, y and z that a header names, None unless it names all three.

    They are the first three texts in brackets in one of its last two lines that are not blank, or
    those of Gwyddion, one for x and y and one for z.
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
    numbers = []
    for match in _NO_DATA.finditer("\n".join(header)):
        try:
            numbers.append(float(match[1]))
        except ValueError:
            continue
    return tuple(numbers)


def of_esri(header: list[str], table: np.ndarray) -> tuple[np.ndarray, Metadata] | None:
    """Return heights (n_y, n_x) and metadata of an ESRI grid, None if the header is none of it.

    Its sizes have no unit. Raises ValueError if the header announces another number of heights than
    there are in `table`, the lines of numbers.
    """
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
    """Read a header of Gwyddion, SPIP, Wyko, Nova, Attocube or others, by SurfaceTopography.

    Parameters
    ----------
    header : list of str
        Lines before the numbers, with decimal points.
    lines, columns : int
        Lines of numbers that follow, and numbers in each.

    Returns
    -------
    (Metadata, float) or None
        The float is the factor from the numbers to heights. None if the header is of another kind,
        or has neither sizes nor a unit.

    Raises
    ------
    ValueError
        If the header describes another quantity than heights, or another number of lines or
        columns.
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
    """Return a text if it is a unit of length, else the first such unit that it has in brackets.

    None if there is none.
    """
    units = [text.strip(), *_IN_BRACKETS.findall(text)]
    return next((unit for unit in units if unit and length_factor(unit)), None)
