"""The edge of the contact, counted in sides of grid cells."""

from typing import Any, NamedTuple

import numpy as np

from ..parallel.halo import next_row
from ..parallel.threads import added


class EdgeSides(NamedTuple):
    """Numbers of sides of grid cells, over all ranks.

    Attributes
    ----------
    along_x, along_y : int
        Between contact and open points, across periodic borders but not at free edges.
    free : int
        Of points in contact, at free edges: beyond them the surface is open.
    mirrored : int
        Of points in contact, at kinks where a map meets its mirror image.
    """

    along_x: int
    along_y: int
    free: int
    mirrored: int


def edge_sides(contact: Any) -> EdgeSides:
    """Count the sides at the edge of a contact. Collective."""
    grid = contact.grid
    rows, points = grid.inside
    starts = np.minimum(grid.starts, grid.nominal[0])
    g, p = (next_row(grid.comm, field[:rows], starts) for field in (contact.g, contact.p))
    below = ((g <= 0) & (p > 0))[None, :points]
    around_x, around_y = contact.periodic
    begin, end = grid.nominal_rows
    if not around_x and end == grid.nominal[0]:
        below = below[:0]
    ends = _ends(contact)
    ridges = _ridges(contact)

    def count(i0: int, i1: int) -> tuple[int, int, int, int]:
        touching = contact.touching(i0, min(i1 + 1, rows))  # with the row below
        touching = np.concatenate([touching, below]) if i1 == rows else touching
        along_y = np.count_nonzero(touching[1:] != touching[:-1])
        touching = touching[: i1 - i0]
        along_x = np.count_nonzero(touching[:, 1:] != touching[:, :-1])
        along_x += around_y * np.count_nonzero(touching[:, 0] != touching[:, -1])
        at_ends = _touching_at(touching, begin + i0, ends)
        at_ridges = _touching_at(touching, begin + i0, ridges)
        return int(along_x), int(along_y), at_ends, at_ridges

    return EdgeSides(*map(int, grid.comm.sum(added(grid.by_rows(count, rows), 4))))


def reaches_free_edges(contact: Any) -> bool:
    """Return whether points at free edges are in contact; looks at these alone. Collective."""
    grid = contact.grid
    begin, end = grid.nominal_rows
    rows, columns = _ends(contact)
    lines: list[Any] = [np.s_[i - begin, : grid.nominal[1]] for i in rows if begin <= i < end]
    lines += [np.s_[: end - begin, j] for j in columns]
    touches = any(((contact.g[k] <= 0) & (contact.p[k] > 0)).any() for k in lines)
    return bool(grid.comm.max([touches])[0])


Lines = tuple[list[int], list[int]]  # numbers of rows, of columns


def _ends(contact: Any) -> Lines:
    """Return the first and the last row and column where the surface has free edges."""
    along_x, along_y = (
        [] if periodic or n == 1 else [0, n - 1]
        for periodic, n in zip(contact.periodic, contact.grid.nominal, strict=True)
    )
    return along_x, along_y


def _ridges(contact: Any) -> Lines:
    """Return the rows and columns beside which a map meets its mirror image."""
    along_x, along_y = (
        [0, n // 2 - 1, n // 2, n - 1] if mirrored and n > 1 else []
        for mirrored, n in zip(contact.surface.ridges, contact.grid.nominal, strict=True)
    )
    return along_x, along_y


def _touching_at(touching: np.ndarray, first_row: int, lines: Lines) -> int:
    """Count the points in contact, of rows from `first_row` on, that lie on lines."""
    rows = [i - first_row for i in lines[0] if 0 <= i - first_row < len(touching)]
    return int(np.count_nonzero(touching[rows]) + np.count_nonzero(touching[:, lines[1]]))
