"""Heights as text, matrices or points in columns; a text with unexplained numbers is refused."""

import re
from collections.abc import Iterator
from dataclasses import replace
from io import BytesIO, TextIOWrapper
from itertools import islice
from typing import Any, NamedTuple

import numpy as np

from ..scene.height_maps import ANY
from ..util.errors import one_line
from . import header, points
from .contents import Contents, is_utf16
from .layout import LOOKED_AT, TextLayout, is_comment, layout_of
from .metadata import Map, Metadata

SAMPLE = 2**17  # bytes in which the layout is looked for
END_OF_ZYGO = re.compile(rb"^\s*#\s*$", re.M)  # after the header, and after the points


class Place(NamedTuple):
    """A part of a text: where it begins, in bytes, and how many lines it has."""

    start: int
    lines: int


class Block(NamedTuple):
    """Successive lines of numbers: where they begin (from 1), what stands before, the numbers."""

    first_line: int
    header: list[str]
    table: np.ndarray


def read(contents: Contents, spec: Any) -> Map:
    """Read a text whole; a matrix as numpy.savetxt writes it (lines are x) unless the header
    differs. ValueError names what is wrong and in which line.
    """
    data = _as_utf8(contents.read())
    stream = BytesIO(data)
    sample = [stream.readline() for _ in range(spec.skip_lines or 0)]
    sample += stream.readlines(SAMPLE)[:LOOKED_AT]
    lines = [line.decode() for line in sample if line]
    layout = layout_of(lines, spec)
    if layout.columns < 2:
        raise ValueError(
            "it has one number in a line, a profile, allowed: a matrix, or columns x, y and z"
        )
    start = sum(map(len, sample[: layout.header_lines]))
    blocks = _blocks(data, start, lines[: layout.header_lines], layout)
    del data, stream  # a map may be large
    title = [] if spec.skip_lines is not None else blocks[0].header
    names = header.columns_named(title, layout.mark, layout.columns)
    if len(blocks) > 1:
        has_points = names is not None or layout.columns == 3
        if _titled(blocks) or not has_points:
            return _one_of(blocks, layout, spec)
        blocks = [_joined(blocks)]  # a blank line ends each line of the grid
    if names is not None:
        x, y, z = (blocks[0].table[:, place] for place in names.places)
        missing = _missing_numbers(title, layout, spec)
        return _points(points.on_grid(x, y, z), missing, names.units, names.unused)
    return _matrix_or_points(blocks[0], layout, title, lines, spec)


def read_zygo(contents: Contents, spec: Any) -> Map:
    """Read Zygo's text of pixels and heights; its header has the points and their distance in m."""
    head, body, *_ = [*END_OF_ZYGO.split(contents.read()), b""]
    table = np.loadtxt(BytesIO(body.replace(b"No Data", b"nan")), comments=None, ndmin=2)
    lines = head.splitlines()
    try:
        n_x, n_y = map(int, lines[3].split()[2:4])
        pitch = float(lines[7].split()[6])  # 0 if it is not known
    except (IndexError, ValueError):
        raise ValueError(
            "its header has no points in line 4 or no distance of them in line 8"
        ) from (None)
    if table.shape != (n_x * n_y, 3):
        raise ValueError(
            f"found {table.shape[0]} lines of {table.shape[1]} numbers, allowed: {n_x} x {n_y}"
            " lines of x, y and z, as its header says"
        )
    heights, _ = points.on_grid(*table.T)
    return heights, Metadata(
        sizes=(n_x * pitch, n_y * pitch) if pitch else None,
        sizes_unit="m" if pitch else "px",
        unit=spec.unit or "um",
        direction="along the column x",
        remarks=() if spec.unit else ("heights are taken in um, Zygo's unit in such a text",),
    )


def _as_utf8(data: bytes) -> bytes:
    """Return a text in UTF-8 without mark, its lines ended by a newline; what is none is cp1252."""
    if is_utf16(data[:4096]):
        is_little = data[1:4096:2].count(0) > data[0:4096:2].count(0)
        without_mark = "utf-16-le" if is_little else "utf-16-be"
        has_mark = data.startswith((b"\xff\xfe", b"\xfe\xff"))
        data = data.decode("utf-16" if has_mark else without_mark, "replace").encode()
    data = data.removeprefix(b"\xef\xbb\xbf")
    if not data.isascii():
        try:
            data.decode()
        except UnicodeDecodeError:
            data = data.decode("cp1252", "replace").encode()
    return data.replace(b"\r\n", b"\n").replace(b"\r", b"\n") if b"\r" in data else data


# -- numbers


def _blocks(data: bytes, start: int, title: list[str], layout: TextLayout) -> list[Block]:
    """Return the blocks between blank lines or comments (one if all have one line)."""
    first_line = layout.header_lines + 1
    stop = len(data)  # without blank lines at the end
    while data[stop - 1 : stop] in (b"\n", b" "):
        stop -= 1
    whole = Place(start, data.count(b"\n", start, stop) + 1)
    table = _plain_table(data, whole, layout)
    if table is not None:
        return [Block(first_line, title, table)]
    blocks = [
        Block(number, comments, _table(data, place, number, layout))
        for number, comments, place in _separated(data, start, title, first_line)
    ]
    has_doubled_line_ends = len(blocks) > 1 and all(len(block.table) == 1 for block in blocks)
    return [_joined(blocks)] if has_doubled_line_ends else blocks


def _separated(
    data: bytes, start: int, title: list[str], first_line: int
) -> Iterator[tuple[int, list[str], Place]]:
    """Yield first line, header and place of each block."""
    comments = list(title)
    lines = 0  # of the present block, which begins at start
    stream = BytesIO(data)
    stream.seek(start)
    number = first_line
    for number, line in enumerate(stream, first_line):
        is_separator = is_comment(line.decode())
        if is_separator or not line.strip(b"\n "):
            if lines:
                yield number - lines, comments, Place(start, lines)
                comments = []
            comments += [line.decode()] * is_separator
            start = stream.tell()
            lines = 0
        else:
            lines += 1
    if lines:
        yield number + 1 - lines, comments, Place(start, lines)


def _joined(blocks: list[Block]) -> Block:
    """Return one block with the numbers of several, and with the header of the first."""
    return blocks[0]._replace(table=np.concatenate([block.table for block in blocks]))


def _lines(data: bytes, place: Place) -> Iterator[str]:
    """Yield the lines of a part of a text, which is not copied."""
    stream = BytesIO(data)
    stream.seek(place.start)
    return islice(TextIOWrapper(stream, "utf-8", newline="\n"), place.lines)


def _plain_table(data: bytes, place: Place, layout: TextLayout) -> np.ndarray | None:
    """Return the numbers of a part of a text by NumPy's parser; None if it refuses or skips a line,
    as where a point is missing.
    """
    lines = _lines(data, place)
    if layout.decimal == ",":
        if layout.mark == "," or data.find(b".", place.start) >= 0:
            return None
        lines = (line.replace(",", ".") for line in lines)
    if layout.ended and layout.mark:
        end = re.compile(rf"{layout.mark}[ \t]*$")
        lines = (end.sub("", line) for line in lines)
    try:
        table = np.loadtxt(
            lines,
            delimiter=layout.mark,
            comments=None,
            quotechar='"' if layout.mark else None,
            ndmin=2,
        )
    except ValueError:
        return None
    return table if table.shape == (place.lines, layout.columns) else None


def _table(data: bytes, place: Place, first_line: int, layout: TextLayout) -> np.ndarray:
    """Return the numbers of a block, nan for missing ones; ValueError names a wrong line."""
    table = _plain_table(data, place, layout)
    if table is not None:
        return table
    table = np.empty((place.lines, layout.columns))
    for row, line in enumerate(_lines(data, place)):
        number = first_line + row
        end = " (it is the last one: is the file complete?)" * (not line.endswith("\n"))
        tokens = layout.tokens(line)
        if len(tokens) != layout.columns:
            raise ValueError(
                f"line {number}: found {len(tokens)} columns, allowed: {layout.columns}, as in line"
                f" {layout.header_lines + 1}{end}"
            )
        values = list(map(layout.number, tokens))
        if None in values:
            raise ValueError(
                f"line {number}: found {tokens[values.index(None)]!r}, allowed: numbers;"
                f" surface.missing names what stands for missing points{end}"
            )
        table[row] = values
    return table


def _missing_numbers(title: list[str], layout: TextLayout, spec: Any) -> tuple[float, ...]:
    """Return the numbers that mark missing points, by header or scene."""
    of_scene = (text.replace(layout.decimal, ".") for text in spec.missing)
    return (*header.missing_numbers(title), *header.numbers_in(of_scene))


# -- maps


def _titled(blocks: list[Block]) -> bool:
    """Whether every block has a header of its own that is not blank."""
    return all(any(line.strip("#\t\r\n ") for line in block.header) for block in blocks)


def _one_of(blocks: list[Block], layout: TextLayout, spec: Any) -> Map:
    """Return the channel spec.dataset, or the first, of several blocks, each of which needs an
    instrument's header: otherwise it may continue the block before.
    """
    places = ", ".join(
        f"{len(block.table)} from line {block.first_line} on" for block in blocks[:4]
    )
    maps: dict[str, Map] = {}
    for block in blocks if _titled(blocks) else ():
        try:
            one_map = _of_instrument(block, layout, spec)
        except ValueError:  # another quantity
            continue
        if one_map is None:
            maps.clear()
            break
        maps.setdefault(one_map[1].channel, one_map)
    if not maps:
        raise ValueError(
            f"it has {len(blocks)} blocks of numbers ({places}), allowed: one map in a text;"
            " surface.skip_lines leaves out what stands before it"
        )
    name = next(iter(maps)) if spec.dataset == ANY else spec.dataset
    if name not in maps:
        allowed = one_line(", ".join(maps))
        raise ValueError(f"surface.dataset: found {name!r}, allowed: {allowed}")
    heights, metadata = maps[name]
    other_names = tuple(channel for channel in maps if channel != name)
    return heights, replace(metadata, other_channels=other_names)


def _of_instrument(block: Block, layout: TextLayout, spec: Any) -> Map | None:
    """Read a block with a known instrument's header, else None; ValueError if they contradict."""
    title = block.header
    if layout.decimal == ",":
        title = [line.replace(",", ".") for line in title]
    metadata_and_factor = header.of_instrument(title, len(block.table), layout.columns)
    if metadata_and_factor is None:
        return None
    metadata, height_factor = metadata_and_factor
    missing = tuple(height_factor * number for number in _missing_numbers(title, layout, spec))
    table = block.table if height_factor == 1.0 else block.table * height_factor
    return table, replace(metadata, missing=missing)


def _matrix_or_points(
    block: Block, layout: TextLayout, title: list[str], sample: list[str], spec: Any
) -> Map:
    """Read a block without names: as ESRI grid, map of an instrument, points x, y, z or a matrix,
    in this order, or raise ValueError.
    """
    table = block.table
    missing = _missing_numbers(title, layout, spec)
    if title and (esri_grid := header.of_esri(title, table)):
        heights, metadata = esri_grid
        return heights, replace(metadata, missing=missing)
    if title and (titled_map := _of_instrument(block, layout, spec)):
        return titled_map
    is_told = spec.coordinates is not None
    grid = None if is_told or layout.columns < 3 else points.whole_grid(table)
    if grid and layout.columns > 3:
        raise ValueError(
            f"its {layout.columns} columns are x, y, z and others, allowed: a header that names"
            " them, or columns x, y and z alone"
        )
    labels = points.labels_of(sample, layout)
    if grid or (layout.columns == 3 and not is_told and not any(labels.signs)):
        grid = grid or points.on_grid(*table.T)
        return _points(grid, missing, header.units_of(title))
    heights, of_lines, of_columns = points.without_coordinates(table, labels, spec.coordinates)
    if heights.shape[1] < 3 and of_columns is None and not is_told:
        raise ValueError("it has two columns, a profile, allowed: a matrix, or columns x, y and z")
    metadata = _of_matrix(heights.shape, of_lines, of_columns, labels.corner, layout)
    return heights, replace(metadata, missing=missing)


def _points(
    grid: tuple[np.ndarray, tuple[float, float]],
    missing: tuple[float, ...],
    units: tuple[str, ...] | None,
    unused: tuple[str, ...] = (),
) -> Map:
    """Return points on a grid with metadata, and a remark on columns that are not used."""
    heights, sizes = grid
    sizes_unit, unit_of_y, unit = units or (None, None, None)
    if sizes_unit != unit_of_y:
        raise ValueError(f"its axes are in different units, {sizes_unit} and {unit_of_y}")
    are = "columns {} are not used" if len(unused) > 1 else "column {} is not used"
    return heights, Metadata(
        sizes,
        sizes_unit,
        unit,
        direction="along the column x",
        missing=missing,
        remarks=(are.format(one_line(", ".join(unused))),) if unused else (),
        reader="x, y, z",
    )


def _of_matrix(
    n: tuple[int, ...],
    of_lines: np.ndarray | None,
    of_columns: np.ndarray | None,
    corner: str | None,
    layout: TextLayout,
) -> Metadata:
    """Return the metadata of a matrix; sizes only if the coordinates have a unit in the corner."""
    remarks = []
    if layout.ended:
        mark = {"\t": "tab"}.get(str(layout.mark), layout.mark)
        remarks.append(f"each line ends with {mark!r}, after which no point is missing")
    unit = header.unit_in_brackets(corner or "")
    sizes = []
    falling = []
    for place, counted, values, k in (
        ("column", "lines", of_lines, n[0]),
        ("line", "columns", of_columns, n[1]),
    ):
        step = 0.0 if values is None else float(values[-1] - values[0]) / max(k - 1, 1)
        falling.append(step < 0)
        sizes.append(abs(step) * k)
        if values is not None:
            is_count = points.numbers_from_0(values) or points.numbers_from_0(values - 1)
            meaning = "numbers of" if is_count else "coordinates of the"
            used = ", which are used" if unit and not is_count and all(sizes) else ""
            remarks.append(
                f"the first {place} is {meaning} {counted}, {values[0]:g} to {values[-1]:g}{used}"
            )
    return Metadata(
        sizes=tuple(sizes) if unit and all(sizes) else None,
        sizes_unit=unit,
        falling=tuple(falling),
        direction="from line to line of the text",
        direction_known=False,
        remarks=tuple(remarks),
    )
