"""The n-th smallest number of a field that is distributed over ranks."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from ..kernels.selection import DIGIT, count_digits

if TYPE_CHECKING:
    from ..parallel.grid import Grid


def nth_smallest(grid: Grid, rows_of: Callable[[int, int], np.ndarray], n: int) -> np.floating:
    """Return the n-th smallest number (from 1) of rows_of(i0, i1), 16 bits a pass. Collective."""
    dtype = rows_of(0, 0).dtype
    size = 8 * dtype.itemsize
    sign = 1 << (size - 1)
    rows, points = grid.inside
    prefix = 0
    rank = float(n)
    for shift in range(size - DIGIT, -1, -DIGIT):
        counts = np.zeros(2**DIGIT)
        digit = np.uint64(sign), np.uint64(shift), np.uint64(prefix)
        for i0, i1 in grid.pieces(rows):
            bits = rows_of(i0, i1).view(f"uint{size}")
            count_digits(bits, (i1 - i0, points), *digit, counts)
        up_to = np.cumsum(grid.comm.sum(counts))
        value = int(np.searchsorted(up_to, rank))
        rank -= float(up_to[value - 1]) if value > 0 else 0.0
        prefix = (prefix << DIGIT) | value
    key = prefix ^ sign if prefix & sign else prefix ^ (2 * sign - 1)
    return np.array([key], f"uint{size}").view(dtype)[0]
