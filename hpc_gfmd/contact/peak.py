"""The largest pressure of a contact, and what its neighbours tell of the peak between points.

Where the pressure is a wave of number q, a point p and its neighbours l and r at a distance a have
2 p - l - r = 4 p sin^2(q a/2), and a peak halfway between two points is 1/cos(q a/2) times as high
as these: sqrt(4 p/(2 p + l + r)), along each axis. A pressure is not negative, so that it is at
most twice as high. Where the contact reaches a free edge, or a ridge between mirror images, it
grows without limit on finer grids, unless it is the hardness. On a profile a patch of one or two
points says nothing of its peak: its load is given, its width is not.
"""

from math import inf, sqrt
from typing import Any, NamedTuple

# Times the estimate: on walls with 2 points for the shortest wave 1 of 100 peaks was beyond the
# estimate itself, 1 of 130 beyond this; with 8 and more points none was beyond either.
CAUTION = 1.3


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


def _is_narrow(n: tuple[int, int], peak: Peak) -> bool:
    """Return whether the peak of a profile is at the edge of its patch."""
    beside = [neighbours for m, neighbours in zip(n, (peak.along_x, peak.along_y)) if m > 1]
    return len(beside) == 1 and min(beside[0]) <= 0
