"""Sizes and wave numbers of the levels of a grid, and which coarse rows a rank owns.

Coarse rows first live where the fine ones do; where ranks have too few they are agglomerated on
every second, fourth, ... rank.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from .threads import piece_rows

if TYPE_CHECKING:
    from .grid import Grid

SQRT2 = np.sqrt(2.0)
Tables = tuple[np.ndarray, np.ndarray, int, np.ndarray, np.ndarray, np.floating]


@dataclass(frozen=True)
class Level:
    """A level: points (n_x, n_y), and largest wave number over sqrt 2 in 1/a of the finest grid."""

    n: tuple[int, int]
    q: float


def levels(grid: Grid) -> list[Level]:
    """List the levels of a grid, finest first, down to one point; only the axis of the smaller
    spacing is halved if they differ by sqrt 2 (semi-coarsening).
    """
    n = grid.n
    spacing = tuple(s / grid.a for s in grid.spacings)
    hierarchy = [Level(n, _nyquist(n, spacing))]
    while max(n) > 1:
        n, spacing = halved(n, spacing)
        q = _nyquist(n, spacing) if max(n) > 1 else hierarchy[-1].q / 2
        hierarchy.append(Level(n, q))
    return hierarchy


def halved(
    n: tuple[int, int], spacing: tuple[float, ...], fewest: int = 2
) -> tuple[tuple[int, int], tuple[float, ...]]:
    """Return points and spacing of the next level; axes of fewer than `fewest` points stay."""
    finest = min((s for s, k in zip(spacing, n) if k >= fewest), default=0.0)
    coarse = [(k + 1) // 2 if k >= fewest and s < SQRT2 * finest else k for k, s in zip(n, spacing)]
    return (coarse[0], coarse[1]), tuple(s * k / c for s, k, c in zip(spacing, n, coarse))


def _nyquist(n: Sequence[int], spacing: Sequence[float]) -> float:
    """Return Grid.q_nyquist of a grid of n points with this spacing; 1 for a single point."""
    q = [np.pi / s for s, k in zip(spacing, n) if k > 1]
    return float(np.sqrt(sum(x * x for x in q) / 2)) or 1.0


@lru_cache(maxsize=256)
def axis_tables(
    n: int, m: int, dtype: np.dtype, start: int = 0, stop: int | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Return J0 and f of fine points start <= i < stop (kernels/multilevel.py), n fine and m coarse
    points on the axis. Cached: do not change them.
    """
    i = np.arange(start, n if stop is None else stop, dtype=np.int64)
    return (i * m // n).astype(np.int32), ((i * m % n) / n).astype(dtype)


def restrict_axis(x: np.ndarray, m: int) -> np.ndarray:
    """Restrict a field (n,) of one periodic axis to m points by full weighting; keeps its mean."""
    J0, f = axis_tables(len(x), m, np.float64)
    return (np.bincount(J0, (1 - f) * x, m) + np.bincount((J0 + 1) % m, f * x, m)) * (m / len(x))


def axis_mode(n: int, m: int) -> int:
    """Return how an axis of n points is coarsened to m: 0 not, 1 exactly halved, 2 otherwise."""
    return 0 if n == m else (1 if n == 2 * m and n > 2 else 2)


def owned_rows(starts: ArrayLike, n: int, m: int) -> np.ndarray:
    """Return the first of m coarse rows of every rank, and m: row J is with fine row floor(J n/m),
    so a rank may own none.
    """
    return -(-np.asarray(starts, dtype=np.int64) * m // n)


def agglomerated(starts: ArrayLike, points: int, share: int) -> np.ndarray:
    """Return the first row of every rank, and their number, gathered on ranks 0, s, 2 s, ..., with
    the smallest power of two s that leaves `share` points each on average.
    """
    starts = np.asarray(starts)
    size = int(np.flatnonzero(np.diff(starts))[-1]) + 1  # the last rank that has any
    leader_limit = max(1, min(int(starts[-1]), points // share))
    stride = 1
    while -(-size // stride) > leader_limit:
        stride *= 2
    leaders = -(-np.arange(len(starts)) // stride) * stride
    return starts[np.minimum(leaders, len(starts) - 1)]


class Transfer:
    """One rank's part of the transfer between a level (n points) and the next coarser one (m).

    Its fine rows begin[r] <= i < end[r], of which row n is row 0, touch a window lo[r] <= J < hi[r]
    of coarse rows; an array of the window has a row more before and after.
    """

    def __init__(
        self,
        n: tuple[int, int],
        m: tuple[int, int],
        begin: ArrayLike,
        end: ArrayLike,
        rank: int,
        dtype: DTypeLike,
    ):
        self.n = n
        self.m = m
        self.rank = rank
        self.dtype: np.dtype = np.dtype(dtype)
        begin, end = (np.asarray(rows, np.int64) for rows in (begin, end))
        self.fine = int(begin[rank]), int(end[rank])
        # windows of all ranks; a last row that lies on a coarse one has no part in the next
        self.lo = begin * m[0] // n[0]
        self.hi = np.where(end > begin, -(-(end - 1) * m[0] // n[0]) + 1, self.lo)

    @cached_property
    def tables(self) -> Tables:
        """What kernels take as `transfer`, a plain tuple; its arrays are shared: do not change."""
        J0, f_x = axis_tables(self.n[0], self.m[0], self.dtype, *self.fine)
        # row numbers count the row before the window
        k0 = (J0 - self.lo[self.rank] + 1).astype(np.int32)
        factor = self.dtype.type(self.m[0] / self.n[0] * self.m[1] / self.n[1])
        return (
            k0,
            f_x,
            axis_mode(self.n[1], self.m[1]),
            *axis_tables(self.n[1], self.m[1], self.dtype),
            factor,
        )

    @property
    def k0(self) -> np.ndarray:
        """The coarse row before each of its fine rows, counted from the row before the window."""
        return self.tables[0]

    @property
    def window_rows(self) -> int:
        """Number of coarse rows in this rank's window."""
        return int(self.hi[self.rank] - self.lo[self.rank])

    @cached_property
    def pieces(self) -> list[tuple[int, int]]:
        """Ranges (begin, end) of its fine rows, from 0 on, that a thread works on at a time."""
        return self.passes(piece_rows(self.n[1]))

    def passes(self, longest: int) -> list[tuple[int, int]]:
        """Split this rank's fine rows into ranges of at most `longest` rows, see `passes_of`."""
        return passes_of(self.k0, longest)


def passes_of(coarse_rows: np.ndarray, longest: int) -> list[tuple[int, int]]:
    """Split fine rows into ranges of at most `longest` that begin at the first fine row of a coarse
    row (unless one has more); coarse_rows: the coarse row before each fine row.
    """
    passes = []
    begin = 0
    count = len(coarse_rows)
    firsts = np.flatnonzero(np.diff(coarse_rows, prepend=-2)).tolist()  # that open a coarse row
    while begin < count:
        end = min(begin + longest, count)
        opens = firsts[bisect_right(firsts, end) - 1]
        end = opens if begin < opens and end < count else end
        passes.append((begin, end))
        begin = end
    return passes
