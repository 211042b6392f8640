"""Passes over a height map: every rank reads a share of the rows, a few at a time."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from ..parallel.layout import row_starts

ROWS = 64  # read at a time


def slabs(start: int, stop: int) -> list[tuple[int, int]]:
    """Cut the rows start <= i < stop into pieces of at most ROWS rows.

    Parameters
    ----------
    start, stop : int

    Returns
    -------
    list of (int, int)
        (start, stop) of each piece, in order.
    """
    return [(row, min(row + ROWS, stop)) for row in range(start, stop, ROWS)]


def own_slabs(topography: Any, comm: Any) -> list[tuple[int, int]]:
    """Return the pieces of a height map that this rank reads. Not collective.

    Parameters
    ----------
    topography : Topography
    comm : Comm

    Returns
    -------
    list of (int, int)
        (start, stop) of this rank's pieces. The map is cut in the same places for any number of
        ranks.
    """
    pieces = slabs(0, topography.n[0])
    starts = row_starts(len(pieces), comm.size)
    return pieces[starts[comm.rank] : starts[comm.rank + 1]]


def with_neighbours(topography: Any, comm: Any, mode: Any) -> Iterator[tuple[int, np.ndarray]]:
    """Read this rank's share of a height map, a piece at a time, with the points around each.

    Parameters
    ----------
    topography : Topography
    comm : Comm
    mode : str
        How points beyond the edges of the map are made: a mode of numpy.pad.

    Yields
    ------
    start : int
        First row of the piece.
    around : ndarray, shape (rows + 2, n_y + 2)
        The piece, which is around[1:-1, 1:-1], and one point more on each side.
    """
    for start, stop in own_slabs(topography, comm):
        begin = max(start - 1, 0)
        end = min(stop + 1, topography.n[0])
        outside = (begin - start + 1, stop + 1 - end)
        yield start, np.pad(topography.rows(begin, end), (outside, (1, 1)), mode)
