"""Connected clusters of points on slabs, periodic or free: how large they are and whether one of
them percolates.

Every rank labels its rows strip by strip (scipy) and keeps of each strip no more than the sizes of
its pieces and the labels along its borders. Pieces that touch across the borders of strips, and of
the periodic cell, are joined; then the blocks of rows of two ranks, of twice two, and so on up a
tree: of each block only the clusters matter that reach its first or its last row. Messages are as
long as two rows, a rank gets one for each doubling of their number at most, and the result is the
same on any number of ranks.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ..kernels.clusters import join

if TYPE_CHECKING:
    from .comm import Comm

STRIP_POINTS = 2**20  # labelled at a time
NOTHING = -1  # label of a point outside the mask
NO_EDGES = np.zeros((0, 4), np.int64)
# what edges of the cell a cluster reaches
FIRST_ROW, LAST_ROW, FIRST_COLUMN, LAST_COLUMN = 1, 2, 4, 8


@dataclass(frozen=True)
class Clusters:
    """sizes: points of the clusters that this rank counts; those of all ranks together are all
    clusters, each once. percolates: along x, along y, the same on all ranks."""

    sizes: np.ndarray
    percolates: tuple[bool, bool]


def find_clusters(
    comm: Comm,
    mask: Callable[[int, int], np.ndarray],
    rows: tuple[int, int],
    n: tuple[int, int],
    periodic: tuple[bool, bool] = (True, True),
    corners: bool = False,
) -> Clusters:
    """The Clusters of the points where a mask is true. Collective.

    mask(i0, i1): local rows i0 <= i < i1, shape (i1 - i0, n_y), bool; rows: (start, stop) of this
    rank, may be empty; n: (n_x, n_y); periodic: whether opposite edges touch, along x and along y;
    corners: whether points belong together that share a corner only (8-connected), instead of a
    side (4-connected).

    A cluster percolates along a periodic axis where it holds a closed way that goes around the cell
    along that axis, so that the cluster has no end there if the cell is repeated (a way that goes
    around both axes counts for both); along a free one where it reaches from the first point to the
    last.
    """
    around_y, counted = (0, 1) if periodic[1] else None, _Counted()

    def join_blocks(upper: _Block | None, lower: _Block | None) -> _Block | None:
        if upper is None or lower is None:
            return lower if upper is None else upper
        lower = lower.renumbered(len(upper.sizes))
        edges = _between(upper.last, lower.first, (0, 0), corners, around_y)
        sizes, sides = np.append(upper.sizes, lower.sizes), np.append(upper.sides, lower.sides)
        return _Joined(edges, sizes, sides, upper.wraps | lower.wraps).block(
            upper.first, lower.last, counted
        )

    block = _local_block(mask, rows, n, periodic, corners, counted) if rows[0] < rows[1] else None
    block, wraps = comm.reduce(block, join_blocks), np.zeros(2, np.bool_)
    if block is not None:
        across = (
            _between(block.last, block.first, (1, 0), corners, around_y)
            if periodic[0]
            else NO_EDGES
        )
        whole = _Joined(across, block.sizes, block.sides, block.wraps)
        counted.add(whole.sizes, whole.sides)
        wraps = whole.wraps
    sizes, sides = counted.all()
    spans = [_reaches(sides, first) for first in (FIRST_ROW, FIRST_COLUMN)]
    percolates = comm.max([wraps[axis] if periodic[axis] else spans[axis] for axis in (0, 1)])
    return Clusters(sizes, (bool(percolates[0]), bool(percolates[1])))


def _reaches(sides: np.ndarray, first: int) -> bool:
    both = first | 2 * first
    return bool(np.any(sides & both == both))


@dataclass(frozen=True)
class _Line:
    """labels: of points in a row or column; shift (2, points): borders crossed from the root of its
    cluster to the point."""

    labels: np.ndarray
    shift: np.ndarray

    @classmethod
    def of(cls, labels: np.ndarray) -> _Line:
        return cls(labels, np.zeros((2, len(labels)), dtype=np.int64))

    def of_roots(self, joined: _Joined, number: np.ndarray) -> _Line:
        """The same with the roots of its pieces, by their new numbers, in place of these."""
        inside = self.labels != NOTHING
        labels, shift, pieces = self.labels.copy(), self.shift.copy(), self.labels[inside]
        labels[inside] = number[joined.parent[pieces]]
        shift[:, inside] += joined.shift[pieces].T
        return _Line(labels, shift)

    def renumbered(self, base: int) -> _Line:
        """The same with numbers that begin at base."""
        return _Line(np.where(self.labels != NOTHING, self.labels + base, NOTHING), self.shift)


@dataclass(frozen=True)
class _Block:
    """The clusters of consecutive rows that reach the first or the last of them. sizes, sides
    (bits): of what they have in these rows; wraps (2,): whether any cluster of these rows goes
    around the cell."""

    first: _Line
    last: _Line
    sizes: np.ndarray
    sides: np.ndarray
    wraps: np.ndarray

    def renumbered(self, base: int) -> _Block:
        """The same with numbers that begin at base."""
        return replace(self, first=self.first.renumbered(base), last=self.last.renumbered(base))


class _Counted:
    """Sizes and sides of clusters that are whole."""

    def __init__(self) -> None:
        self._parts = [(np.zeros(0, np.int64), np.zeros(0, np.uint8))]

    def add(self, sizes: np.ndarray, sides: np.ndarray) -> None:
        """Of roots of clusters; pieces that are none have no size."""
        self._parts.append((sizes[sizes > 0], sides[sizes > 0]))

    def all(self) -> tuple[np.ndarray, np.ndarray]:
        """(sizes, sides) of all of them."""
        sizes, sides = zip(*self._parts)
        return np.concatenate(sizes), np.concatenate(sides)


def _between(
    a: _Line, b: _Line, across: tuple[int, int], corners: bool, around: tuple[int, int] | None
) -> np.ndarray:
    """Edges (m, 4) of points that touch on neighbouring lines a, b. across: borders crossed from a
    to b, (x, y); around: None, or those crossed from the last point of a line to its first."""
    points = len(a.labels)
    pairs = [(slice(None), slice(None), (0, 0))]
    if corners:
        pairs += [(slice(0, -1), slice(1, None), (0, 0)), (slice(1, None), slice(0, -1), (0, 0))]
        if around is not None:
            back = -around[0], -around[1]
            pairs += [
                (slice(points - 1, None), slice(0, 1), around),
                (slice(0, 1), slice(points - 1, None), back),
            ]
    found = []
    for on_a, on_b, along in pairs:
        crossed = a.shift[:, on_a] - b.shift[:, on_b] + np.add(across, along)[:, None]
        edges = np.stack([a.labels[on_a], b.labels[on_b], *crossed], axis=1)
        edges = edges[(edges[:, :2] != NOTHING).all(axis=1)]
        again = (edges[1:] == edges[:-1]).all(axis=1)
        found.append(edges[np.append(True, ~again)[: len(edges)]])
    return np.concatenate(found)


class _Joined:
    """Pieces after `join`: parent, shift and wraps as there; sizes and sides (bits) of whole
    clusters at their roots, else 0."""

    def __init__(
        self,
        edges: np.ndarray,
        sizes: np.ndarray,
        sides: np.ndarray,
        wraps: ArrayLike = (False, False),
    ):
        pieces = len(sizes)
        self.parent, self.shift = np.arange(pieces), np.zeros((pieces, 2), dtype=np.int64)
        self.wraps = np.array(wraps, np.bool_)
        join(edges, self.parent, self.shift, self.wraps)
        self.sizes, self.sides = np.zeros(pieces, dtype=np.int64), np.zeros(pieces, dtype=np.uint8)
        np.add.at(self.sizes, self.parent, sizes)
        np.bitwise_or.at(self.sides, self.parent, sides)

    def block(self, first: _Line, last: _Line, counted: _Counted) -> _Block:
        """The _Block of rows from line `first` to line `last`; clusters that reach neither are
        counted."""
        reached = np.zeros(len(self.sizes), np.bool_)
        for line in (first, last):
            reached[self.parent[line.labels[line.labels != NOTHING]]] = True
        counted.add(self.sizes[~reached], self.sides[~reached])
        number = np.cumsum(reached) - 1
        return _Block(
            first.of_roots(self, number),
            last.of_roots(self, number),
            self.sizes[reached],
            self.sides[reached],
            self.wraps,
        )


def _local_block(
    mask: Callable[[int, int], np.ndarray],
    rows: tuple[int, int],
    n: tuple[int, int],
    periodic: tuple[bool, bool],
    corners: bool,
    counted: _Counted,
) -> _Block:
    """The _Block of the rows of one rank, which has some."""
    from scipy import ndimage

    structure = ndimage.generate_binary_structure(2, 2 if corners else 1)
    strip, count = max(1, STRIP_POINTS // n[1]), 0
    around_y = (0, 1) if periodic[1] else None
    sizes, sides, edges = [], [], [NO_EDGES]
    lines: list[_Line] = []  # the first and the last row of every strip
    for i0 in range(0, rows[1] - rows[0], strip):
        labels, found = ndimage.label(mask(i0, min(i0 + strip, rows[1] - rows[0])), structure)
        sizes.append(np.bincount(labels.ravel(), minlength=found + 1)[1:])
        top, bottom, left, right = (
            np.where(one > 0, one + (count - 1), NOTHING).astype(np.int64)
            for one in (labels[0], labels[-1], labels[:, 0], labels[:, -1])
        )
        if lines:
            edges.append(_between(lines[-1], _Line.of(top), (0, 0), corners, around_y))
        if around_y is not None:
            edges.append(_between(_Line.of(right), _Line.of(left), around_y, corners, None))
        lines += _Line.of(top), _Line.of(bottom)

        reached = np.zeros(found + 1, np.uint8)
        at_end = rows[0] + i0 + len(labels) == n[0]
        for side, line, there in (
            (FIRST_ROW, labels[0], rows[0] + i0 == 0),
            (LAST_ROW, labels[-1], at_end),
            (FIRST_COLUMN, labels[:, 0], True),
            (LAST_COLUMN, labels[:, -1], True),
        ):
            if there:
                reached[line] |= side
        sides.append(reached[1:])
        count += found
    return _Joined(np.concatenate(edges), np.concatenate(sizes), np.concatenate(sides)).block(
        lines[0], lines[-1], counted
    )
