"""Connected clusters of points on slabs, periodic or free: how large they are and whether one of
them percolates.

Every rank labels its rows strip by strip (scipy) and keeps of each strip no more than the clusters
that reach its first or its last row: a block. Two blocks that touch are joined to one, those of the
strips of a rank one after the other, those of the ranks up a tree; clusters that no longer reach a
border are whole and counted where they become so. Messages are as long as two rows, a rank gets one
for each doubling of their number at most, and the result is the same on any number of ranks.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..kernels.clusters import join

if TYPE_CHECKING:
    from .comm import Comm

STRIP_POINTS = 2**20  # labelled at a time
NOTHING = -1  # label of a point outside the mask
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
    """Find the Clusters of the points where a mask is true. Collective.

    mask(i0, i1): local rows i0 <= i < i1, shape (i1 - i0, n_y), bool; rows: (start, stop) of this
    rank, may be empty; n: (n_x, n_y); periodic: whether opposite edges touch, along x and along y;
    corners: whether points belong together that share a corner only (8-connected), instead of a
    side (4-connected).

    A cluster percolates along a periodic axis where it holds a closed way that goes around the cell
    along that axis, so that the cluster has no end there if the cell is repeated (a way that goes
    around both axes counts for both); along a free one where it reaches from the first point to the
    last.
    """
    joiner, block, (start, stop) = _Joiner(corners, periodic[1]), None, rows
    strip = max(1, STRIP_POINTS // n[1])
    for i0 in range(start, stop, strip):
        i1 = min(i0 + strip, stop)
        at_ends = (i0 == 0) * FIRST_ROW, (i1 == n[0]) * LAST_ROW
        block = joiner.together(block, joiner.labelled(mask(i0 - start, i1 - start), *at_ends))
    block, wraps = comm.reduce(block, joiner.together), np.zeros(2, np.bool_)
    if block is not None:
        wraps = joiner.closed(block, periodic[0]).wraps
    sizes, sides = (np.concatenate(parts) for parts in zip(*joiner.whole))
    spans = [_reaches(sides, first) for first in (FIRST_ROW, FIRST_COLUMN)]
    percolates = comm.max([wraps[axis] if periodic[axis] else spans[axis] for axis in (0, 1)])
    return Clusters(sizes, (bool(percolates[0]), bool(percolates[1])))


def _reaches(sides: np.ndarray, first: int) -> bool:
    both = first | 2 * first
    return bool(np.any(sides & both == both))


@dataclass(frozen=True)
class _Block:
    """The clusters of consecutive rows that reach the first or the last of them.

    first, last (3, n_y): of every point of these rows its cluster, or NOTHING, and how many borders
    of the cell, along x and along y, are crossed on the way to it from the root of that; sizes,
    sides (bits): of what clusters have in these rows; wraps (2,): whether any cluster of these rows
    goes around the cell."""

    first: np.ndarray
    last: np.ndarray
    sizes: np.ndarray
    sides: np.ndarray
    wraps: np.ndarray


class _Joiner:
    """Makes one block of two. corners: as in `find_clusters`; around: whether the ends of a row
    touch; whole: (sizes, sides) of the clusters that have no point in a border left."""

    def __init__(self, corners: bool, around: bool):
        self.corners, self.around = corners, around
        self.whole = [(np.zeros(0, np.int64), np.zeros(0, np.uint8))]

    def labelled(self, mask: np.ndarray, first_row: int, last_row: int) -> _Block:
        """Make the block of a strip; first_row, last_row: what edges of the cell its ends are."""
        from scipy import ndimage

        structure = ndimage.generate_binary_structure(2, 2 if self.corners else 1)
        labels, found = ndimage.label(mask, structure)
        sides = np.zeros(found + 1, np.uint8)
        lines = labels[0], labels[-1], labels[:, 0], labels[:, -1]
        for line, side in zip(lines, (first_row, last_row, FIRST_COLUMN, LAST_COLUMN)):
            sides[line] |= side
        # of a point outside the mask the label is NOTHING
        first, last, left, right = (
            np.stack([line.astype(np.int64) - 1, 0 * line, 0 * line]) for line in lines
        )
        pairs = self._pairs(right, left, (0, 1), False) if self.around else []
        sizes = np.bincount(labels.ravel(), minlength=found + 1)[1:]
        return self._joined(pairs, sizes, sides[1:], np.zeros(2, np.bool_), first, last)

    def together(self, upper: _Block | None, lower: _Block | None) -> _Block | None:
        """Make one block of two, of which the second begins where the first one ends; None is
        none."""
        if upper is None or lower is None:
            return lower if upper is None else upper
        first, last = lower.first.copy(), lower.last.copy()
        for line in first, last:
            line[0, line[0] != NOTHING] += len(upper.sizes)
        return self._joined(
            self._pairs(upper.last, first, (0, 0), self.around),
            np.append(upper.sizes, lower.sizes),
            np.append(upper.sides, lower.sides),
            upper.wraps | lower.wraps,
            upper.first,
            last,
        )

    def closed(self, block: _Block, around: bool) -> _Block:
        """Return what is left of the block of all rows, all clusters being whole: no border.
        around: whether its last row touches its first."""
        pairs = self._pairs(block.last, block.first, (1, 0), self.around) if around else []
        border = block.first[:, :0]
        return self._joined(pairs, block.sizes, block.sides, block.wraps, border, border)

    def _pairs(
        self, a: np.ndarray, b: np.ndarray, across: tuple[int, int], around: bool
    ) -> list[np.ndarray]:
        """Return the edges (4, m), as `join` takes them transposed, between the points that touch
        on neighbouring lines. across: borders crossed from a to b; around: whether the ends of the
        lines touch."""
        ways = [(slice(None), slice(None), 0)]
        if self.corners:
            ways += [(slice(0, -1), slice(1, None), 0), (slice(1, None), slice(0, -1), 0)]
        if self.corners and around:
            ways += [(slice(-1, None), slice(0, 1), 1), (slice(0, 1), slice(-1, None), -1)]
        found = []
        for on_a, on_b, turn in ways:
            crossed = a[1:, on_a] - b[1:, on_b] + np.array([across]).T
            crossed[1] += turn
            edges = np.concatenate([a[:1, on_a], b[:1, on_b], crossed])
            found.append(edges[:, (edges[:2] != NOTHING).all(axis=0)])
        return found

    def _joined(
        self,
        pairs: list[np.ndarray],
        sizes: np.ndarray,
        sides: np.ndarray,
        wraps: np.ndarray,
        first: np.ndarray,
        last: np.ndarray,
    ) -> _Block:
        """Make the block of rows from line `first` to line `last` whose pieces have these sizes and
        sides; counts the clusters that reach neither line."""
        parent, shift = np.arange(len(sizes)), np.zeros((len(sizes), 2), np.int64)
        edges = np.concatenate([np.zeros((4, 0), np.int64), *pairs], axis=1)
        join(np.ascontiguousarray(edges.T), parent, shift, wraps)
        of_cluster, reached = np.zeros_like(sizes), np.zeros(len(sizes), np.bool_)
        np.add.at(of_cluster, parent, sizes)
        sides_of_cluster = np.zeros_like(sides)
        np.bitwise_or.at(sides_of_cluster, parent, sides)
        for line in first, last:
            reached[parent[line[0, line[0] != NOTHING]]] = True
        whole = ~reached & (of_cluster > 0)  # pieces that are no root have no size
        self.whole.append((of_cluster[whole], sides_of_cluster[whole]))

        number = np.cumsum(reached) - 1

        def of_roots(line: np.ndarray) -> np.ndarray:
            inside = line[0] != NOTHING
            line, pieces = line.copy(), line[0, inside]
            line[0, inside] = number[parent[pieces]]
            line[1:, inside] += shift[pieces].T
            return line

        return _Block(
            of_roots(first), of_roots(last), of_cluster[reached], sides_of_cluster[reached], wraps
        )
