"""Matrices in a text whose first line or column may be coordinates or mere numbering."""

from dataclasses import dataclass

import numpy as np

from .coordinates import FEWEST, changes_evenly, is_plane, numbers_from_0
from .layout import NoNumber, TextLayout, is_whole

HINT = (
    'surface.coordinates = "line", "column", "both" or "none" tells which of the first line and'
    " column are coordinates"
)


@dataclass(frozen=True)
class Matrix:
    """Heights of a matrix, and the coordinates that stood beside them.

    Attributes
    ----------
    heights : ndarray, shape (lines, columns)
    of_lines : ndarray, shape (lines,), optional
        Coordinates of the lines, from the first column; None if that is heights.
    of_columns : ndarray, shape (columns,), optional
        Coordinates of the columns, from the first line; None if that is heights.
    """

    heights: np.ndarray
    of_lines: np.ndarray | None = None
    of_columns: np.ndarray | None = None


@dataclass(frozen=True)
class Labels:
    """Signs that the first line or column of a matrix is not heights.

    Attributes
    ----------
    corner : str or None
        The first token of the first line, if it is not a number.
    above : ndarray or None
        Numbers in the line above the matrix, after its first token, if that line fits the columns.
    names_index : bool
        Whether a line above names the columns, and has no name, or "index", for the first one.
    whole_line, whole_column : bool
        Whether the first line, or the first column, is of whole numbers and all others have
        decimals.
    """

    corner: str | None = None
    above: np.ndarray | None = None
    names_index: bool = False
    whole_line: bool = False
    whole_column: bool = False

    @property
    def any(self) -> bool:
        """Whether there is any sign."""
        return (
            self.above is not None
            or self.corner is not None
            or (self.names_index or self.whole_line or self.whole_column)
        )


def labels_of(sample: list[str], layout: TextLayout) -> Labels:
    """Look for signs that the first line or column of a matrix is not heights.

    Parameters
    ----------
    sample : list of str
        First lines of the text, with the header.
    layout : TextLayout

    Returns
    -------
    Labels
        The signs that were found. Nothing is decided and nothing raised here.
    """
    rows = [layout.tokens(line) for line in sample[layout.header_lines :] if line.strip()]
    rows = [row for row in rows if len(row) == layout.columns]
    whole = [[is_whole(token) for token in row] for row in rows]
    corner: str | None = rows[0][0] if rows and not rows[0][0] else None
    above = None
    names_index = False
    if layout.header_lines:
        title = layout.tokens(sample[layout.header_lines - 1].lstrip("#"))
        if len(title) == layout.columns and layout.columns > 1:
            try:
                above = np.array([layout.number(token) for token in title[1:]])
                corner = title[0]
            except NoNumber:
                names_index = title[0].lower() in ("", "index", "unnamed: 0")
    start = 0 if above is not None else 1
    body = [row[1:] for row in whole[start:]]
    first_line = whole[0][1:] if whole and above is None else [True]
    has_body = len(body) > 1 and any(body)
    return Labels(
        corner,
        above,
        names_index,
        has_body and all(first_line) and not any(any(row) for row in body),
        has_body and all(row[0] for row in whole) and not any(any(row) for row in body),
    )


def without_coordinates(table: np.ndarray, labels: Labels, coordinates: str | None) -> Matrix:
    """Separate the heights of a matrix from coordinates in its first line and column.

    Parameters
    ----------
    table : ndarray, shape (lines, columns)
    labels : Labels
    coordinates : str, optional
        Whether the first line, the first column or both are coordinates, as the scene says:
        "none", "line", "column" or "both". None: the labels and even steps decide.

    Returns
    -------
    Matrix

    Raises
    ------
    ValueError
        If it cannot be decided whether the first line or column is heights, or if coordinates are
        not evenly spaced.
    """
    if coordinates is not None:
        return _split_declared(table, labels, coordinates)
    if labels.above is not None:
        return _with_both(table[:, 1:], table[:, 0], labels.above)
    if labels.corner is not None and changes_evenly(table[0, 1:], 2):
        return _with_both(table[1:, 1:], table[1:, 0], table[0, 1:])
    if labels.names_index and changes_evenly(table[:, 0], 2):
        return Matrix(table[:, 1:], of_lines=table[:, 0])
    if min(table.shape) > 1 and is_plane(table):
        return Matrix(table)
    if changes_evenly(table[0, 1:]) and changes_evenly(table[1:, 0]):
        return _with_numbers_in_the_corner(table, labels)
    heights = table
    of_columns = of_lines = None
    if _is_label(table, labels.whole_line, "line"):
        heights = table[1:]
        of_columns = table[0]
    elif _is_label(table.T, labels.whole_column, "column"):
        heights = table[:, 1:]
        of_lines = table[:, 0]
    return Matrix(heights, of_lines, of_columns)


def _with_numbers_in_the_corner(table: np.ndarray, labels: Labels) -> Matrix:
    """Decide on a matrix whose first line and column change evenly, with a number in the corner.

    Returns it with or without coordinates. Whole numbers beside decimals are coordinates; a small
    matrix that changes evenly with its corner is all heights. Raises ValueError if the first line
    and column may be either.
    """
    line = table[0, 1:]
    column = table[1:, 0]
    inside = table[1:, 1:]
    if labels.whole_line and labels.whole_column:
        return _with_both(inside, column, line)
    continues = changes_evenly(table[0]) and changes_evenly(table[:, 0])
    few = min(line.size, column.size) < FEWEST
    if few and continues:  # as in any small map of whole numbers
        return Matrix(table)
    if few or continues or changes_evenly(inside[0]) or changes_evenly(inside[:, 0]):
        raise ValueError(f"its first line and column rise evenly: {HINT}")
    return _with_both(inside, column, line)


def _is_label(table: np.ndarray, is_whole_line: bool, place: str) -> bool:
    """Whether the first line of a table only numbers the columns, from 0 on.

    To ask for the first column, pass the transposed table. is_whole_line: the first line has whole
    numbers and all others have decimals. place: "line" or "column", for the message. Raises
    ValueError if the line may be heights too.
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


def _with_both(heights: np.ndarray, of_lines: np.ndarray, of_columns: np.ndarray) -> Matrix:
    """Return the Matrix of heights with coordinates of both lines and columns.

    Raises ValueError if coordinates do not change evenly.
    """
    for values, place in ((of_columns, "line"), (of_lines, "column")):
        if not changes_evenly(values, 2):
            raise ValueError(f"the coordinates in its first {place} do not rise evenly: {HINT}")
    return Matrix(heights, of_lines, of_columns)


def _split_declared(table: np.ndarray, labels: Labels, coordinates: str) -> Matrix:
    """Separate the coordinates that the scene declares ("none", "line", "column" or "both").

    Coordinates of the columns in a line above the table (labels.above) take the place of its first
    line. Raises ValueError if they do not change evenly.
    """
    has_line = coordinates in ("line", "both")
    has_column = coordinates in ("column", "both")
    of_columns = None
    of_lines = None
    if has_line and labels.above is None:
        of_columns = table[0]
        table = table[1:]
    elif has_line:
        of_columns = labels.above
    if has_column:
        of_lines = table[:, 0]
        table = table[:, 1:]
        if of_columns is not None and labels.above is None:
            of_columns = of_columns[1:]
    for values, place in ((of_columns, "line"), (of_lines, "column")):
        if values is not None and not changes_evenly(values, 2):
            raise ValueError(f"the coordinates in its first {place} do not rise evenly")
    return Matrix(table, of_lines, of_columns)
