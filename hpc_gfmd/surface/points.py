"""Points x, y, z of a text on a grid, and coordinates in the first line and column of a matrix."""

from contextlib import suppress
from typing import NamedTuple

import numpy as np

from .layout import TextLayout
from .metadata import UNEVEN

FEWEST = 8  # numbers that do not rise evenly by chance
NO_GRID = "its points are not those of a regular grid"
ON_A_LINE = "its points lie on one line, a profile, allowed: points of a regular grid"
SPARSE = 8  # times as many points of a grid as are given, at most
HINT = (
    'surface.coordinates = "line", "column", "both" or "none" tells which of the first line and'
    " column are coordinates"
)


# -- points


def on_grid(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, tuple[float, float]]:
    """Put points on a regular grid: heights (n_x, n_y), nan where none, and the sizes (points times
    distance). ValueError if they are on none, fill less than 1/SPARSE or repeat.
    """
    along = np.ptp(y) * (x - x.min())
    across = (np.abs(along - np.ptp(x) * part).max() for part in (y - y.min(), y.max() - y))
    if min(across) <= UNEVEN * np.ptp(x) * np.ptp(y) / x.size:
        raise ValueError(ON_A_LINE)
    del along
    i, n_x, a_x = _grid_lines(x)
    j, n_y, a_y = _grid_lines(y)
    if n_x * n_y > SPARSE * z.size:
        raise ValueError(NO_GRID)
    heights = np.full((n_x, n_y), np.nan)
    place = i * n_y + j
    if np.unique(place).size < place.size:
        raise ValueError("it has a point twice")
    heights.ravel()[place] = z
    return heights, (a_x * n_x, a_y * n_y)


def _grid_lines(coordinates: np.ndarray) -> tuple[np.ndarray, int, float]:
    """Return the line of each point from 0, the number of evenly spaced lines, and their distance,
    up to rounding of the written digits; at least 1/SPARSE of them must have a point.
    """
    values = np.unique(coordinates)
    if not np.isfinite(values).all() or values.size < 2:
        raise ValueError(NO_GRID)
    gaps = np.diff(values)
    wide = gaps[gaps > 0.25 * gaps.max()]
    n = int(np.rint(wide / np.median(wide)).sum()) + 1
    if n > SPARSE * values.size:
        raise ValueError(NO_GRID)
    if n == values.size and np.ptp(gaps) <= UNEVEN * gaps.mean():
        origin = float(values[0])
        step = float(gaps.mean())
    else:
        line = np.rint((values - values[0]) * (n - 1) / (values[-1] - values[0]))
        step, origin = np.polyfit(line, values, 1).tolist()
        deviation = np.abs(values - origin - line * step)
        allowed = UNEVEN * step + 0.6 * _rounding(values)
        if (deviation > np.minimum(allowed, 0.3 * step)).any():
            raise ValueError(NO_GRID)
    return np.rint((coordinates - origin) / step).astype(np.intp), n, step


def whole_grid(table: np.ndarray) -> tuple[np.ndarray, tuple[float, float]] | None:
    """Return `on_grid` of a table whose first columns are x, y and z of every point of a grid, each
    once; None for any other.
    """
    x, y, z = table[:, :3].T
    if np.unique(x).size * np.unique(y).size != len(table):
        return None
    with suppress(ValueError):
        heights, sizes = on_grid(x, y, z)
        if heights.size == len(table):
            return heights, sizes
    return None


# -- coordinates beside a matrix


class Labels(NamedTuple):
    """Signs that the first line or column of a matrix is not heights."""

    corner: str | None  # the first token of the first line, if it is not a number
    # Numbers in the line above the matrix, after its first token, if that line fits the columns.
    above: np.ndarray | None
    # Whether a line above names the columns, and has no name, or "index", for the first one.
    names_index: bool
    whole_line: bool  # the first line is of whole numbers, all others have decimals
    whole_column: bool  # the first column is of whole numbers, all others have decimals

    @property
    def signs(self) -> tuple[bool, ...]:
        """Whether there is each of the signs."""
        return (self.corner is not None, self.above is not None, *self[2:])


def labels_of(sample: list[str], layout: TextLayout) -> Labels:
    """Find signs that the first line or column of a matrix is not heights, in the first lines."""
    rows = [layout.tokens(line) for line in sample[layout.header_lines :] if line.strip()]
    rows = [row for row in rows if len(row) == layout.columns]
    corner: str | None = rows[0][0] if rows and not rows[0][0] else None
    above = None
    names_index = False
    title = layout.tokens(sample[layout.header_lines - 1].lstrip("#"))
    if layout.header_lines and len(title) == layout.columns:
        numbers = [layout.number(token) for token in title[1:]]
        if None in numbers:
            names_index = title[0].lower() in ("", "index", "unnamed: 0")
        else:
            above = np.array(numbers, dtype=np.float64)
            corner = title[0]
    whole = [[token.lstrip("+-").isdigit() for token in row] for row in rows]
    body = [row[1:] for row in whole[0 if above is not None else 1 :]]
    first_line = whole[0][1:] if whole and above is None else [True]
    alone = len(body) > 1 and any(body) and not any(map(any, body))
    return Labels(
        corner,
        above,
        names_index,
        alone and all(first_line),
        alone and all(row[0] for row in whole),
    )


def without_coordinates(
    table: np.ndarray, labels: Labels, declared: str | None
) -> tuple[np.ndarray, np.ndarray | None, np.ndarray | None]:
    """Return heights, coordinates of the lines (first column) and columns (first line). declared:
    which are coordinates; None: labels and even steps decide, or ValueError.
    """
    if declared is None:
        has_line, has_column = _has_coordinates(table, labels)
    else:
        has_line = declared in ("line", "both")
        has_column = declared in ("column", "both")
    of_columns = labels.above if has_line else None
    if has_line and labels.above is None:
        of_columns = table[0, int(has_column) :]
        table = table[1:]
    of_lines = table[:, 0] if has_column else None
    for values, place in ((of_columns, "line"), (of_lines, "column")):
        if values is not None and not changes_evenly(values, 2):
            hint = f": {HINT}" if declared is None else ""
            raise ValueError(f"the coordinates in its first {place} do not rise evenly{hint}")
    return table[:, int(has_column) :], of_lines, of_columns


def _has_coordinates(table: np.ndarray, labels: Labels) -> tuple[bool, bool]:
    """Whether the first line and the first column are coordinates; ValueError if either may be."""
    if labels.above is not None:
        return True, True
    if labels.corner is not None and changes_evenly(table[0, 1:], 2):
        return True, True
    if labels.names_index and changes_evenly(table[:, 0], 2):
        return False, True
    if min(table.shape) > 1 and _is_plane(table):
        return False, False
    line = table[0, 1:]
    column = table[1:, 0]
    if not (changes_evenly(line) and changes_evenly(column)):
        has_line = _only_counts(table, labels.whole_line, "line")
        return has_line, not has_line and _only_counts(table.T, labels.whole_column, "column")
    if labels.whole_line and labels.whole_column:
        return True, True
    continues = changes_evenly(table[0]) and changes_evenly(table[:, 0])
    few = min(line.size, column.size) < FEWEST
    if few and continues:  # as in any small map of whole numbers
        return False, False
    if few or continues or changes_evenly(table[1, 1:]) or changes_evenly(table[1:, 1]):
        raise ValueError(f"its first line and column rise evenly: {HINT}")
    return True, True


def _only_counts(table: np.ndarray, is_whole_line: bool, place: str) -> bool:
    """Whether the first line (column: transposed) only numbers the columns from 0; ValueError if it
    may be heights too. is_whole_line: only it has whole numbers.
    """
    line = table[0]
    if len(table) < 3 or line.size < 3 or not changes_evenly(line):
        return False
    counts = numbers_from_0(line)
    if counts and is_whole_line:
        return True
    if counts or (line.size >= FEWEST and not changes_evenly(table[1])):
        raise ValueError(f"its first {place} rises evenly: {HINT}")
    return False


def changes_evenly(values: np.ndarray, fewest: int = 3) -> bool:
    """Whether numbers, at least `fewest`, rise or fall in even steps, as coordinates do."""
    if values.size < fewest or not np.isfinite(values).all():
        return False
    steps = np.diff(values)
    step = steps.mean()
    allowed = np.minimum(UNEVEN * abs(step) + _rounding(values)[1:], 0.05 * abs(step))
    return bool(step and (np.abs(steps - step) <= allowed).all())


def numbers_from_0(values: np.ndarray) -> bool:
    """Whether values are 0, 1, 2, ..., at least two of them."""
    return values.size > 1 and bool(np.array_equal(values, np.arange(values.size)))


def _is_plane(table: np.ndarray) -> bool:
    """Whether values lie on a plane, to a tenth of a step: even steps then tell nothing."""
    lines, columns = (np.arange(n) / max(n - 1, 1) for n in table.shape)
    corner = table[0, 0]
    steps = [abs(table[-1, 0] - corner) / len(lines), abs(table[0, -1] - corner) / len(columns)]
    allowed = 0.1 * max(steps)
    across = corner + columns * (table[0, -1] - corner)
    planes = (across + line * (table[-1, 0] - corner) for line in lines)
    return all(np.abs(row - plane).max() <= allowed for row, plane in zip(table, planes))


def _rounding(values: np.ndarray) -> np.ndarray:
    """Return one unit of the last digit of each coordinate, all with as many decimals or digits as
    the longest, whichever is coarser; 0 for more than 12 digits.
    """
    written = [np.format_float_scientific(abs(value)).split("e") for value in values.tolist()]
    digits = np.array([len(mantissa.replace(".", "")) for mantissa, _ in written])
    powers = np.array([int(power) for _, power in written])
    significant = digits.max()
    if significant > 12:  # written in full
        return np.zeros(values.size)
    decimals = (digits - 1 - powers).max()
    return np.maximum(10.0**-decimals, 10.0 ** (powers + 1 - significant))
