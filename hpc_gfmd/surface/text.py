"""Heights as text: matrices, or points with columns x, y and z, with or without a header.

Every number is accounted for; otherwise the text is refused.
"""

from collections.abc import Iterator
from dataclasses import replace
from io import TextIOWrapper
from itertools import islice
from typing import Any

import numpy as np

from ..scene.height_maps import ANY
from ..util.errors import one_line
from . import header
from .blocks import Block, joined, plain_block, read_blocks
from .contents import Contents, encoding_of
from .coordinates import is_grid, numbers_from_0, points_on_grid
from .layout import LOOKED_AT, TextLayout, layout_of
from .metadata import Map, Metadata
from .tables import Matrix, labels_of, without_coordinates

ALONG_LINE = "along a line of the text"
ACROSS_LINES = "from line to line of the text"


def read(contents: Contents, spec: Any) -> Map:
    """Read a text whole.

    A matrix is taken as numpy.savetxt writes it: its first index, the line, is x, unless the header
    says otherwise.

    Parameters
    ----------
    contents : Contents
    spec : scene.File
        Its skip_lines, decimal, missing, coordinates and dataset are used.

    Returns
    -------
    heights : ndarray, shape (lines, columns) of a matrix or (n_x, n_y) of points
        float64, nan where they are missing.
    metadata : Metadata

    Raises
    ------
    ValueError
        Names what is wrong, and in which line.
    """
    try:
        return _read(contents, spec, encoding_of(contents.head()))
    except UnicodeDecodeError:
        return _read(contents, spec, "cp1252")  # Western Windows, a superset of Latin-1's letters


def _read(contents: Contents, spec: Any, encoding: str) -> Map:
    """Read a text as `read` does. Raises UnicodeDecodeError if it has another encoding."""
    sample = list(islice(_lines(contents, encoding), (spec.skip_lines or 0) + LOOKED_AT))
    layout = layout_of(sample, spec)
    if layout.columns < 2:
        raise ValueError(
            "it has one number in a line, a profile, allowed: a matrix, or columns x, y and z"
        )
    plain = plain_block(_lines(contents, encoding), layout)
    blocks = [plain] if plain else read_blocks(_lines(contents, encoding), layout)
    title = [] if spec.skip_lines is not None else blocks[0].header
    names = header.columns_named(title, layout.mark, layout.columns)
    if len(blocks) > 1:
        has_points = names is not None or layout.columns == 3
        if _titled(blocks) or not has_points:
            return _one_of(blocks, layout, spec)
        blocks = [joined(blocks)]  # a blank line ends each line of the grid
    if names is not None:
        return _points(blocks[0], names, title, layout, spec)
    return _matrix_or_points(blocks[0], layout, title, sample, spec)


def _lines(contents: Contents, encoding: str) -> Iterator[str]:
    """Yield the lines of a text, each with its line end.

    Raises UnicodeDecodeError if it is not UTF-8; in other encodings such bytes are replaced.
    """
    errors = "strict" if encoding == "utf-8-sig" else "replace"
    with contents.open() as stream, TextIOWrapper(stream, encoding, errors=errors) as text:
        yield from text


def _titled(blocks: list[Block]) -> bool:
    """Whether every block has a header of its own that is not blank."""
    return all(any(line.strip("#\t\r\n ") for line in block.header) for block in blocks)


def _one_of(blocks: list[Block], layout: TextLayout, spec: Any) -> Map:
    """Return one map of a text with several blocks of numbers.

    Every block needs the header of an instrument, and those of heights are channels: the map is the
    channel that spec.dataset names, or the first one. Raises ValueError if there is none, or if a
    block has another header: it may belong to the one before it.
    """
    places = ", ".join(f"{block.lines} from line {block.first_line} on" for block in blocks[:4])
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
    """Read a block with a header of an instrument; None if the header is not one that is known.

    Returns heights of shape (lines, columns) in the unit that the header gives, and metadata.
    Raises ValueError if the header describes another quantity than heights or other numbers of
    points.
    """
    title = block.header
    if layout.decimal == ",":
        title = [line.replace(",", ".") for line in title]
    metadata_and_factor = header.of_instrument(title, block.lines, layout.columns)
    if metadata_and_factor is None:
        return None
    metadata, height_factor = metadata_and_factor
    table = _without_missing(block.table(), header.missing_numbers(title), layout, spec)
    return (table if height_factor == 1.0 else table * height_factor), metadata


def _points(
    block: Block, names: header.Columns, title: list[str], layout: TextLayout, spec: Any
) -> Map:
    """Put points whose columns are named x, y and z on a grid. Raises ValueError if they fit none.

    names: the columns of the block. title: lines of the header. Returns heights of shape
    (n_x, n_y) and metadata, with a remark on columns that are not used.
    """
    table = block.table()
    x, y, z = (table[:, place] for place in names.places)
    z = _without_missing(z, header.missing_numbers(title), layout, spec)
    heights, sizes = points_on_grid(x, y, z)
    unused = one_line(", ".join(names.unused))
    remarks = (f"column {unused} is not used",) if len(names.unused) == 1 else ()
    remarks = (f"columns {unused} are not used",) if len(names.unused) > 1 else remarks
    return heights, _of_points(sizes, names.units, remarks)


def _of_points(
    sizes: tuple[float, float], units: tuple[str, ...] | None, remarks: tuple[str, ...] = ()
) -> Metadata:
    """Return the metadata of points on a grid. Raises ValueError if x and y have different units.

    sizes: (L_x, L_y) in the unit of x. units: those of x, y and z; None if they are not known.
    remarks: those of the metadata.
    """
    sizes_unit, unit_of_y, unit = units or (None, None, None)
    if sizes_unit != unit_of_y:
        raise ValueError(f"its axes are in different units, {sizes_unit} and {unit_of_y}")
    return Metadata(
        sizes, sizes_unit, unit, direction="along the column x", remarks=remarks, reader="x, y, z"
    )


def _matrix_or_points(
    block: Block, layout: TextLayout, title: list[str], sample: list[str], spec: Any
) -> Map:
    """Read a block of numbers whose columns have no names.

    In this order it is taken as an ESRI grid, as the map of an instrument, as points with columns
    x, y and z, and as a matrix, with or without coordinates. title: lines of the header. sample:
    first lines of the text. Raises ValueError if it is none of them.
    """
    missing = header.missing_numbers(title)
    if title and (grid := header.of_esri(title, block.table())):
        heights, metadata = grid
        return _without_missing(heights, missing, layout, spec), metadata
    if title and (titled_map := _of_instrument(block, layout, spec)):
        return titled_map
    table = block.table()
    if spec.coordinates is None and layout.columns >= 3 and is_grid(table):
        if layout.columns > 3:
            raise ValueError(
                f"its {layout.columns} columns are x, y, z and others, allowed: a header that names"
                " them, or columns x, y and z alone"
            )
        z = _without_missing(table[:, 2], missing, layout, spec)
        heights, sizes = points_on_grid(table[:, 0], table[:, 1], z)
        return heights, _of_points(sizes, header.units_of(title))
    labels = labels_of(sample, layout)
    is_told = spec.coordinates is not None
    if layout.columns == 3 and not is_told and not labels.any:
        z = _without_missing(table[:, 2], missing, layout, spec)
        heights, sizes = points_on_grid(table[:, 0], table[:, 1], z)
        return heights, _of_points(sizes, header.units_of(title))
    matrix = without_coordinates(table, labels, spec.coordinates)
    if matrix.heights.shape[1] < 3 and matrix.of_columns is None and not is_told:
        raise ValueError("it has two columns, a profile, allowed: a matrix, or columns x, y and z")
    heights = _without_missing(matrix.heights, missing, layout, spec)
    return heights, _of_matrix(matrix, labels.corner, layout)


def _of_matrix(matrix: Matrix, corner: str | None, layout: TextLayout) -> Metadata:
    """Return the metadata of a matrix; it has sizes only if coordinates have a unit.

    corner: text in the corner of the coordinates, which may name that unit.
    """
    remarks = []
    if layout.ended:
        mark = {"\t": "tab"}.get(str(layout.mark), layout.mark)
        remarks.append(f"each line ends with {mark!r}, after which no point is missing")
    unit = header.unit_in_brackets(corner or "")
    sizes = []
    falling = []
    coordinates = {"column": matrix.of_lines, "line": matrix.of_columns}
    for (place, values), n in zip(coordinates.items(), matrix.heights.shape):
        step = 0.0 if values is None else float(values[-1] - values[0]) / max(n - 1, 1)
        falling.append(step < 0)
        sizes.append(abs(step) * n)
        if values is not None:
            is_count = numbers_from_0(values) or numbers_from_0(values - 1)
            meaning = "numbers of" if is_count else "coordinates of the"
            used = ", which are used" if unit and not is_count and all(sizes) else ""
            counted = {"column": "lines", "line": "columns"}[place]
            remarks.append(
                f"the first {place} is {meaning} {counted}, {values[0]:g} to {values[-1]:g}{used}"
            )
    return Metadata(
        sizes=tuple(sizes) if unit and all(sizes) else None,
        sizes_unit=unit,
        falling=tuple(falling),
        direction=ACROSS_LINES,
        direction_known=False,
        remarks=tuple(remarks),
    )


def _without_missing(
    values: np.ndarray, missing: tuple[float, ...], layout: TextLayout, spec: Any
) -> np.ndarray:
    """Return values with nan in place of the numbers that mark missing points.

    missing: the marks that the header names. Those in spec.missing are added, with the decimal mark
    of the text.
    """
    numbers = list(missing)
    for text in spec.missing:
        try:
            numbers.append(float(text.replace(layout.decimal, ".")))
        except ValueError:
            continue
    return np.where(np.isin(values, numbers), np.nan, values) if numbers else values
