"""Passes over a height map: every rank reads a share of the rows, a few at a time."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from ..parallel.layout import row_starts

ROWS = 64  # read at a time


def slabs(start: int, stop: int) -> list[tuple[int, int]]:
    """Cut rows into pieces.

    Parameters
    ----------
    start, stop : int
        The rows start <= i < stop.

    Returns
    -------
    list of (int, int)
        (start, stop) of pieces of ROWS rows at most.
    """
    return [(row, min(row + ROWS, stop)) for row in range(start, stop, ROWS)]


def own_slabs(topography: Any, comm: Any) -> list[tuple[int, int]]:
    """Return this rank's share of a height map.

    Parameters
    ----------
    topography : Topography
    comm : Comm

    Returns
    -------
    list of (int, int)
        (start, stop) of pieces of rows that are the same for any number of ranks.
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
        What numpy.pad puts where the map ends.

    Yields
    ------
    start : int
        First row of the piece.
    around : ndarray, shape (rows + 2, n_y + 2)
        The piece, which is around[1:-1, 1:-1], and a point more on each side.
    """
    for start, stop in own_slabs(topography, comm):
        begin = max(start - 1, 0)
        end = min(stop + 1, topography.n[0])
        outside = (begin - start + 1, stop + 1 - end)
        yield start, np.pad(topography.rows(begin, end), (outside, (1, 1)), mode)
