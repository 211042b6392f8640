"""What neighbours tell of the pressure between points: of its largest peak, and of its minima.

Where the pressure is a wave of number q, a point p and its neighbours l and r at a distance a have
2 p - l - r = 4 p sin^2(q a/2), and a peak halfway between two points is 1/cos(q a/2) times as high
as these: sqrt(4 p/(2 p + l + r)), along each axis. A pressure is not negative, so that it is at
most twice as high. Where the contact reaches a free edge, or a ridge between mirror images, it
grows without limit on finer grids, unless it is the hardness. On a profile a patch of one or two
points says nothing of its peak: its load is given, its width is not.

A contact that is nearly full opens at the minima of the pressure, which may lie between points: at
the vertex of the parabola through a point and its neighbours, at most half a spacing away.
"""

from math import inf, sqrt
from typing import Any, NamedTuple

import numpy as np

from ..parallel.halo import neighbours

# Times the estimate: on walls with 2 points for the shortest wave 1 of 100 peaks was beyond the
# estimate itself, 1 of 130 beyond this; with 8 and more points none was beyond either.
# Times the drop to minima: of 500 waves and walls next to full contact 92 areas were beyond their
# error without them, one is with this.
CAUTION = 1.3
NEARLY_FULL = 0.9  # share of the points from which on minima are looked at, as none opens below


class Peak(NamedTuple):
    """The largest pressure of a point, and those of its neighbours along x and along y."""

    p: float
    along_x: tuple[float, float]
    along_y: tuple[float, float]

    @property
    def between_points(self) -> float:
        """The largest height of a peak between points, over p."""
        l_x, r_x = self.along_x
        l_y, r_y = self.along_y
        return 4 * self.p / sqrt((2 * self.p + l_x + r_x) * (2 * self.p + l_y + r_y))


def peak_of(contact: Any) -> Peak:
    """Return the peak of a contact in the program's units; across borders it is that of a periodic
    surface. Collective.
    """
    grid = contact.grid
    n_x, n_y = grid.nominal
    begin, end = grid.nominal_rows

    def largest(i0: int, i1: int) -> tuple[float, int, int]:
        """Return the largest pressure, and minus the place of the first such point."""
        p = contact.pressure_rows(i0, i1)
        i, j = divmod(int(p.argmax()), n_y)
        return float(p[i, j]), -(begin + i0 + i), -j

    of_rank = max(grid.by_rows(largest, grid.inside[0]), default=(-inf, 0, 0))
    p, i, j = max(grid.comm.allgather(of_rank))
    points = [(-i - 1, -j), (-i + 1, -j), (-i, -j - 1), (-i, -j + 1)]
    beside = [0.0] * len(points)
    for k, (row, column) in enumerate((x % n_x, y % n_y) for x, y in points):
        if begin <= row < end:
            beside[k] = float(contact.pressure_rows(row - begin, row - begin + 1)[0, column])
    left, right, below, above = map(float, grid.comm.sum(beside))
    return Peak(p, (left, right), (below, above))


def pressure_max_discretisation(contact: Any) -> float | None:
    """Estimate the relative error of the largest pressure by the grid spacing: inf where it has no
    limit, None without contact. Collective.
    """
    edges = contact.edges
    peak = contact.peak
    if not peak.p > 0:
        return None
    has_limit = edges.free == edges.mirrored == 0 and not _is_narrow(contact.grid.nominal, peak)
    error = CAUTION * (peak.between_points - 1) if has_limit else inf
    if contact.hardness is not None:
        error = min(error, contact.hardness / contact.pressure_unit / peak.p - 1)
    return max(error, 0.0)


def may_open(contact: Any) -> int:
    """Count the points in contact beside which the pressure may fall below 0, if nearly all points
    touch. Collective.
    """
    if contact.contact_points < NEARLY_FULL * contact.N:
        return 0
    grid = contact.grid
    rows = grid.inside[0]
    around_x, around_y = contact.periodic
    # the first and the last row of each rank that has any
    ends = [(0, min(1, rows)), (max(rows - 1, 0), rows)]
    borders = np.concatenate([contact.pressure_rows(*end) for end in ends])
    have_rows = np.diff(np.minimum(grid.starts, grid.nominal[0])) > 0
    starts = np.append(0, np.cumsum(2 * have_rows))
    before, after = neighbours(grid.comm, borders, starts, 1)
    begin, _ = grid.nominal_rows

    def count(i0: int, i1: int) -> int:
        p = contact.pressure_rows(max(i0 - 1, 0), min(i1 + 1, rows))
        # beyond an end there is nothing to see
        row_before = p[:1] if begin + i0 == 0 and not around_x else before
        row_after = p[-1:] if begin + i1 == grid.nominal[0] and not around_x else after
        above = [row_before] if i0 == 0 else []
        below = [row_after] if i1 == rows else []
        p = np.concatenate([*above, p, *below])
        middle = p[1:-1]
        along_y = np.pad(middle, ((0, 0), (1, 1)), "wrap" if around_y else "edge")
        drop = _drop(p[:-2], middle, p[2:]) + _drop(along_y[:, :-2], middle, along_y[:, 2:])
        return int(np.count_nonzero(contact.touching(i0, i1) & (middle < CAUTION * drop)))

    return int(grid.comm.sum([sum(grid.by_rows(count, rows))])[0])


def _drop(left: np.ndarray, p: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Return by how much parabolas fall below their middle points within half a spacing."""
    bend = left + right - 2 * p
    is_valley = bend > 0
    slope = (right - left) / 2
    way = np.clip(-slope / np.where(is_valley, bend, 1), -0.5, 0.5)
    return np.where(is_valley, -way * (slope + bend * way / 2), 0)


def _is_narrow(n: tuple[int, int], peak: Peak) -> bool:
    """Return whether the peak of a profile is at the edge of its patch."""
    beside = [neighbours for m, neighbours in zip(n, (peak.along_x, peak.along_y)) if m > 1]
    return len(beside) == 1 and min(beside[0]) <= 0
