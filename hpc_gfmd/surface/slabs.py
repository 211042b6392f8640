"""Passes over a height map: every rank reads a share of the rows, a few at a time."""

from typing import Any

import numpy as np

from ..parallel.layout import row_starts

ROWS = 64  # read at a time


def slabs(first: int, last: int) -> list[tuple[int, int]]:
    """Cut the rows first <= i < last into pieces [(start, stop), ...]."""
    return [(start, min(start + ROWS, last)) for start in range(first, last, ROWS)]


def own_slabs(found: Any, comm: Any) -> list[tuple[int, int]]:
    """Return this rank's share of a Topography, in pieces that are the same for any number of
    ranks."""
    pieces = slabs(0, found.n[0])
    first, last = row_starts(len(pieces), comm.size)[comm.rank :][:2]
    return pieces[first:last]


def with_neighbours(found: Any, start: int, stop: int, mode: Any) -> np.ndarray:
    """Return rows of a Topography with a point more on all sides; mode: what numpy.pad puts where
    the map ends."""
    first, last = max(start - 1, 0), min(stop + 1, found.n[0])
    return np.pad(found.rows(first, last), ((first - start + 1, stop + 1 - last), (1, 1)), mode)
