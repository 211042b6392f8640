"""The grid on which a surface is solved: beyond edges that are free the cell goes on."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..bodies.images import NEEDED
from ..parallel.grid import Grid


@dataclass(frozen=True)
class FreeSpace:
    """How far the cell goes on beyond a surface that ends: the largest of these. Measured by what
    more of it changes, see tests/physics/test_free.py."""

    share: float = 1 / 2  # of the axis
    # of the geometric mean of the axis and twice the longest side, which keeps the modes few that
    # are coupled (bodies/free.py)
    of_longest: float = 0.42
    points: int = 64
    spacings: float = 2 * NEEDED  # of any axis that ends, to resolve these modes
    periodic_spacings: int = 4  # of any other axis
    # square of the longest side over product of a side and what is beside it, at most: else S
    # would not be positive
    slender: int = 256


FREE_SPACE = FreeSpace()


def cell_of(n: tuple, free: tuple[bool, bool], sizes: tuple[float, ...]) -> tuple:
    """Return the points along each axis that a surface of n points and these sizes is solved on:
    more along the axes where it ends."""
    from scipy.fft import next_fast_len

    space, axes = FREE_SPACE, list(zip(n, sizes, free))
    longest = max((size for _, size, ends in axes if ends), default=0.0)
    length = max((size for k, size, _ in axes if k > 1), default=0.0)
    beside = [
        size / k * (space.spacings if ends else space.periodic_spacings)
        for k, size, ends in axes
        if ends or k > 1
    ]
    cell = []
    for k, size, ends in axes:
        longer = k
        if ends:
            least = max([*beside, min(length**2 / (space.slender * size), length / 2)]) * k / size
            mean = (k * (longest * k / size) ** 2) ** (1 / 3)
            beyond = max(k * space.share, space.of_longest * mean, space.points, least)
            step = 16 if k + beyond > 128 else 4  # the levels halve it
            longer = step * int(next_fast_len(-(-(k + math.ceil(beyond)) // step), real=True))
        cell.append(longer)
    return tuple(cell)


def grid_of(
    n: tuple, sizes: tuple[float, ...], comm: Any, free: tuple[bool, bool], threads: int = 1
) -> Grid:
    """Make the grid on which a surface of n points is solved."""
    cell = cell_of(n, free, sizes)
    whole = tuple(size * m / k for size, m, k in zip(sizes, cell, n))
    return Grid.kept(cell, whole, comm, threads, nominal=n)


def nominal_part(grid: Grid) -> Grid:
    """Return the grid of the nominal area alone, whose rows lie on the same ranks."""
    if not grid.padded:
        return grid
    starts = np.minimum(grid.starts, grid.nominal[0])
    return Grid.kept(grid.nominal, grid.nominal_sizes, grid.comm, grid.threads, starts)
