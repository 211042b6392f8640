"""Passes over a height map: every rank reads a share of the rows, a few at a time."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ..parallel.guard import collective_errors
from ..parallel.layout import row_starts

ROWS = 64  # read at a time


def own_slabs(n: int, comm: Any) -> list[tuple[int, int]]:
    """Cut this rank's share of n rows into pieces [(start, stop), ...]."""
    first, last = map(int, row_starts(n, comm.size)[comm.rank : comm.rank + 2])
    return [(start, min(start + ROWS, last)) for start in range(first, last, ROWS)]


def with_neighbours(found: Any, start: int, stop: int, **beyond: Any) -> np.ndarray:
    """Return rows of a Topography with a point more on all sides; beyond: what numpy.pad puts where
    the map ends."""
    first, last = max(start - 1, 0), min(stop + 1, found.n[0])
    return np.pad(found.rows(first, last), ((first - start + 1, stop + 1 - last), (1, 1)), **beyond)


def local(comm: Any, make: Callable[[], Any]) -> Any:
    """Return what make() gives on each rank; what it raises on one is raised on all. Collective."""
    with collective_errors(comm, "reading the surface"):
        return make()
