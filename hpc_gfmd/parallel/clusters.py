"""Connected clusters of points on slabs: how large they are and whether one percolates.

Every rank labels its rows strip by strip (scipy) and keeps the clusters that reach the first or
last row of a strip, a block. Blocks are joined, those of the ranks up a tree with messages of two
rows; a cluster that no longer reaches a border is counted on that rank.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..kernels.clusters import join

if TYPE_CHECKING:
    from .comm import Comm

STRIP_POINTS = 2**20  # points that are labelled at a time
NOTHING = -1  # label of a point outside the mask


@dataclass(frozen=True)
class Clusters:
    """Points of each cluster counted on this rank; percolation along x and y, the same on all."""

    sizes: np.ndarray
    percolates: tuple[bool, bool]


def find_clusters(
    comm: Comm,
    mask: Callable[[int, int], np.ndarray],
    rows: tuple[int, int],
    n: tuple[int, int],
    periodic: tuple[bool, bool],
    corners: bool,
) -> Clusters:
    """Find the clusters where mask(i0, i1) of local rows is true; n = (n_x, n_y). Collective.

    Points that share only a corner are connected if `corners`. A cluster percolates along a
    periodic axis if it contains a closed way around the cell, along a free axis if it reaches from
    end to end.
    """
    joiner = _Joiner(n, periodic, corners)
    block = None
    start, stop = rows
    strip = max(1, STRIP_POINTS // n[1])
    for i0 in range(start, stop, strip):
        i1 = min(i0 + strip, stop)
        block = joiner.together(block, joiner.labelled(mask(i0 - start, i1 - start), i0))
    block = comm.reduce(block, joiner.together)
    if block is not None:
        joiner.close(block)
    along_x, along_y = comm.max(joiner.percolates)
    return Clusters(np.concatenate(joiner.whole), (bool(along_x), bool(along_y)))


@dataclass(frozen=True)
class _Block:
    """The clusters of consecutive rows that reach the first or the last of them.

    first_row, last_row (3, n_y): number of the cluster of each point, or NOTHING; borders of the
    cell crossed along x and y from the root of the cluster. counts (5, clusters): points of each in
    all rows, in the first and last row, in the first and last column of the cell.
    """

    first_row: np.ndarray
    last_row: np.ndarray
    counts: np.ndarray


class _Joiner:
    """Joins blocks; clusters off the borders go to `whole`. Sets `percolates` (2,)."""

    def __init__(self, n: tuple[int, int], periodic: tuple[bool, bool], corners: bool):
        self.n = n
        self.periodic = periodic
        self.corners = corners
        self.whole = [np.zeros(0, np.int64)]
        self.percolates = np.zeros(2, np.bool_)

    def labelled(self, mask: np.ndarray, i0: int) -> _Block:
        """Label the clusters of a strip, a mask (rows, n_y) from row i0 of the whole field on."""
        from scipy import ndimage

        structure = ndimage.generate_binary_structure(2, 2 if self.corners else 1)
        labels, cluster_count = ndimage.label(mask, structure)
        lines = labels[0], labels[-1], labels[:, 0], labels[:, -1]
        ends = i0 == 0, i0 + len(mask) == self.n[0], True, True
        counted = [labels.ravel(), *(line * end for line, end in zip(lines, ends))]
        counts = np.stack([np.bincount(line, minlength=cluster_count + 1)[1:] for line in counted])
        # of a point outside the mask the label is NOTHING
        first_row, last_row, left, right = (
            np.stack([line.astype(np.int64) - 1, 0 * line, 0 * line]) for line in lines
        )
        pairs = self._pairs(right, left, (0, 1)) if self.periodic[1] else []
        return self._joined(pairs, counts, first_row, last_row)

    def together(self, upper: _Block | None, lower: _Block | None) -> _Block | None:
        """Return the block of the rows of two blocks; None stands for no rows."""
        if upper is None or lower is None:
            return lower if upper is None else upper
        lower_first = lower.first_row.copy()
        lower_last = lower.last_row.copy()
        for line in lower_first, lower_last:
            line[0, line[0] != NOTHING] += upper.counts.shape[1]
        counts = np.concatenate([upper.counts, lower.counts], axis=1)
        pairs = self._pairs(upper.last_row, lower_first)
        return self._joined(pairs, counts, upper.first_row, lower_last)

    def close(self, block: _Block) -> None:
        """Count the clusters of the block of all rows, joined across a periodic border."""
        pairs = self._pairs(block.last_row, block.first_row, (1, 0)) if self.periodic[0] else []
        border = block.first_row[:, :0]
        self._joined(pairs, block.counts, border, border)

    def _pairs(
        self, a: np.ndarray, b: np.ndarray, across: tuple[int, int] = (0, 0)
    ) -> list[np.ndarray]:
        """Return edges (4, edges), for `join`, between touching points of neighbouring lines a and
        b (3, points). across: borders of the cell crossed from a to b, along x and y.
        """
        ways = [(slice(None), slice(None), 0)]
        if self.corners:
            ways += [(slice(0, -1), slice(1, None), 0), (slice(1, None), slice(0, -1), 0)]
        if self.corners and self.periodic[1] and not across[1]:  # the ends of two rows
            ways += [(slice(-1, None), slice(0, 1), 1), (slice(0, 1), slice(-1, None), -1)]
        edges_of_ways = []
        for on_a, on_b, turn in ways:
            crossed = a[1:, on_a] - b[1:, on_b] + np.array([across]).T
            crossed[1] += turn
            edges = np.concatenate([a[:1, on_a], b[:1, on_b], crossed])
            edges_of_ways.append(edges[:, (edges[:2] != NOTHING).all(axis=0)])
        return edges_of_ways

    def _joined(
        self,
        pairs: list[np.ndarray],
        counts: np.ndarray,
        first_row: np.ndarray,
        last_row: np.ndarray,
    ) -> _Block:
        """Return the block between two rows, joined; clusters that reach neither go to `whole`."""
        pieces = counts.shape[1]
        parent = np.arange(pieces)
        shift = np.zeros((pieces, 2), np.int64)
        edges = np.concatenate([np.zeros((4, 0), np.int64), *pairs], axis=1)
        join(np.ascontiguousarray(edges.T), parent, shift, self.percolates)
        joined = counts.copy()
        merged = np.flatnonzero(parent != np.arange(pieces))
        np.add.at(joined.T, parent[merged], counts.T[merged])
        joined[:, merged] = 0
        reached = np.zeros(pieces, np.bool_)
        for line in first_row, last_row:
            reached[parent[line[0, line[0] != NOTHING]]] = True
        whole = joined[:, ~reached & (joined[0] > 0)]  # those that are no root have no points
        self.whole.append(whole[0])
        across = (np.minimum(whole[1::2], whole[2::2]) > 0).any(axis=1)
        self.percolates |= across & ~np.array(self.periodic)
        number = np.cumsum(reached) - 1

        def of_roots(line: np.ndarray) -> np.ndarray:
            inside = line[0] != NOTHING
            pieces_inside = line[0, inside]
            renumbered = line.copy()
            renumbered[0, inside] = number[parent[pieces_inside]]
            renumbered[1:, inside] += shift[pieces_inside].T
            return renumbered

        return _Block(of_roots(first_row), of_roots(last_row), joined[:, reached])
