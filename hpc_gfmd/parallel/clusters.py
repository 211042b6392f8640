"""Connected clusters of points on slabs, periodic or free: how large they are and whether one of them percolates.

Every rank labels its rows strip by strip (scipy) and keeps of each strip no more than the sizes of its pieces and the labels along its
borders. Pieces that touch across the borders of strips, and of the periodic cell, are joined; then the clusters that reach the first or
the last row of a rank are joined on rank 0. Messages are as long as those rows, and the result is the same on any number of ranks.
"""

from dataclasses import dataclass

import numpy as np

from ..kernels.clusters import join
from . import halo

STRIP_POINTS = 2**20  # labelled at a time
NOTHING = -1  # label of a point outside the mask
FIRST_ROW, LAST_ROW, FIRST_COLUMN, LAST_COLUMN = 1, 2, 4, 8  # what edges of the cell a cluster reaches


@dataclass(frozen=True)
class Clusters:
    """sizes: points of the clusters that this rank counts; those of all ranks together are all clusters, each once. percolates: along
    x, along y, the same on all ranks."""

    sizes: np.ndarray
    percolates: tuple[bool, bool]


def find_clusters(comm, mask, rows, n, periodic=(True, True), corners=False):
    """The Clusters of the points where a mask is true. Collective.

    mask(i0, i1): local rows i0 <= i < i1, shape (i1 - i0, n_y), bool; rows: (start, stop) of this rank, may be empty; n: (n_x, n_y);
    periodic: whether opposite edges touch, along x and along y; corners: whether points belong together that share a corner only
    (8-connected), instead of a side (4-connected).

    A cluster percolates along a periodic axis where it holds a closed way that goes around the cell along that axis, so that the
    cluster has no end there if the cell is repeated (a way that goes around both axes counts for both); along a free one where it
    reaches from the first point to the last.
    """
    local = _Local(mask, rows, n, periodic, corners)
    base = comm.before(len(local.sizes))
    mine = [line and line.of_ranks(local, base) for line in (local.first, local.last)]
    edges = _between_ranks(comm, *mine, rows[1] == n[0], periodic, corners)
    at_border = np.unique(np.concatenate([line.labels[line.labels != NOTHING] for line in mine] if local.first else [[]])).astype(int)
    here = at_border - base
    found = comm.gather((at_border, local.sizes[here], local.sides[here], edges))

    sizes, sides = np.delete(local.sizes, here), np.delete(local.sides, here)
    sizes, sides, wraps = sizes[sizes > 0], sides[sizes > 0], local.wraps
    if comm.rank == 0:
        ids, parts, reached, edges = (np.concatenate(one) for one in zip(*found, strict=True))
        edges[:, :2] = np.searchsorted(ids, edges[:, :2])
        joined = _Joined(edges, parts, reached)
        whole = joined.sizes > 0
        sizes, sides = np.append(sizes, joined.sizes[whole]), np.append(sides, joined.sides[whole])
        wraps = wraps | joined.wraps
    spans = [_reaches(sides, first) for first in (FIRST_ROW, FIRST_COLUMN)]
    percolates = comm.max([wraps[axis] if periodic[axis] else spans[axis] for axis in (0, 1)])
    return Clusters(sizes, tuple(bool(one) for one in percolates))


def _reaches(sides, first):
    both = first | 2 * first
    return np.any(sides & both == both)


@dataclass(frozen=True)
class _Line:
    """labels: of points in a row or column; shift (2, points): borders crossed from the root of its cluster to the point."""

    labels: np.ndarray
    shift: np.ndarray

    @classmethod
    def of(cls, labels):
        return cls(labels, np.zeros((2, len(labels)), dtype=np.int64))

    def of_ranks(self, local, base):
        """The same with the clusters of the rank in place of their pieces, numbered over all ranks."""
        inside = self.labels != NOTHING
        labels, shift = self.labels.copy(), self.shift.copy()
        pieces = self.labels[inside]
        labels[inside], shift[:, inside] = local.parent[pieces] + base, local.shift[pieces].T
        return _Line(labels, shift)


def _between(a, b, across, corners, around):
    """Edges (m, 4) of points that touch on neighbouring lines a, b. across: borders crossed from a to b, (x, y); around: None, or those
    crossed from the last point of a line to its first."""
    points = len(a.labels)
    pairs = [(slice(None), slice(None), (0, 0))]
    if corners:
        pairs += [(slice(0, -1), slice(1, None), (0, 0)), (slice(1, None), slice(0, -1), (0, 0))]
        if around is not None:
            back = tuple(-k for k in around)
            pairs += [(slice(points - 1, None), slice(0, 1), around), (slice(0, 1), slice(points - 1, None), back)]
    found = []
    for on_a, on_b, along in pairs:
        crossed = a.shift[:, on_a] - b.shift[:, on_b] + np.add(across, along)[:, None]
        edges = np.stack([a.labels[on_a], b.labels[on_b], *crossed], axis=1)
        edges = edges[(edges[:, :2] != NOTHING).all(axis=1)]
        again = (edges[1:] == edges[:-1]).all(axis=1)
        found.append(edges[np.append(True, ~again)[:len(edges)]])
    return np.concatenate(found)


class _Joined:
    """Pieces after `join`: parent, shift and wraps as there; sizes and sides (bits) of whole clusters at their roots, else 0."""

    def __init__(self, edges, sizes, sides):
        pieces = len(sizes)
        self.parent, self.shift = np.arange(pieces), np.zeros((pieces, 2), dtype=np.int64)
        self.wraps = np.zeros(2, dtype=np.bool_)
        join(edges, self.parent, self.shift, self.wraps)
        self.sizes, self.sides = np.zeros(pieces, dtype=np.int64), np.zeros(pieces, dtype=np.uint8)
        np.add.at(self.sizes, self.parent, sizes)
        np.bitwise_or.at(self.sides, self.parent, sides)


class _Local(_Joined):
    """The clusters of one rank. first, last: _Line of its first and last row in pieces, None without rows."""

    def __init__(self, mask, rows, n, periodic, corners):
        from scipy import ndimage

        structure = ndimage.generate_binary_structure(2, 2 if corners else 1)
        strip, count = max(1, STRIP_POINTS // n[1]), 0
        around_y = (0, 1) if periodic[1] else None
        sizes, sides, edges = [np.zeros(0, int)], [np.zeros(0, np.uint8)], [np.zeros((0, 4), int)]
        self.first = self.last = None
        for i0 in range(0, rows[1] - rows[0], strip):
            labels, found = ndimage.label(mask(i0, min(i0 + strip, rows[1] - rows[0])), structure)
            sizes.append(np.bincount(labels.ravel(), minlength=found + 1)[1:])
            top, bottom, left, right = (np.where(one > 0, one + (count - 1), NOTHING).astype(np.int64)
                                        for one in (labels[0], labels[-1], labels[:, 0], labels[:, -1]))
            if self.last is not None:
                edges.append(_between(self.last, _Line.of(top), (0, 0), corners, around_y))
            if periodic[1]:
                edges.append(_between(_Line.of(right), _Line.of(left), around_y, corners, None))
            self.first, self.last = self.first or _Line.of(top), _Line.of(bottom)

            reached = np.zeros(found + 1, np.uint8)
            last = rows[0] + i0 + len(labels) == n[0]
            for side, line, there in ((FIRST_ROW, labels[0], rows[0] + i0 == 0), (LAST_ROW, labels[-1], last),
                                      (FIRST_COLUMN, labels[:, 0], True), (LAST_COLUMN, labels[:, -1], True)):
                if there:
                    reached[line] |= side
            sides.append(reached[1:])
            count += found
        super().__init__(np.concatenate(edges), np.concatenate(sizes), np.concatenate(sides))


def _between_ranks(comm, first, last, at_end, periodic, corners):
    """Edges between the clusters of this rank's last row and those of the row that follows it, perhaps its own first one."""
    below = halo.next_row(comm, np.zeros((3, 0, 0)) if first is None else np.stack([first.labels, *first.shift])[:, None])
    if last is None or (at_end and not periodic[0]):
        return np.zeros((0, 4), int)
    return _between(last, _Line(below[0], below[1:]), (int(at_end), 0), corners, (0, 1) if periodic[1] else None)
