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
    more of it changes, see tests/physics/test_free.py.

    Attributes
    ----------
    share : float
        Of the axis.
    of_longest : float
        Of the geometric mean of the axis and twice the longest side, which keeps the modes few that
        are coupled (bodies/free.py).
    points : int
    spacings : float
        Of any axis that ends, to resolve these modes.
    periodic_spacings : int
        Of any other axis.
    slender : int
        Square of the longest side over product of a side and what is beside it, at most: else S
        would not be positive.
    """

    share: float = 1 / 2
    of_longest: float = 0.42
    points: int = 64
    spacings: float = 2 * NEEDED
    periodic_spacings: int = 4
    slender: int = 256


FREE_SPACE = FreeSpace()


def cell_of(n: tuple, free: tuple[bool, bool], sizes: tuple[float, ...]) -> tuple:
    """Return on how many points along each axis a surface is solved: more along the axes where it
    ends.

    Parameters
    ----------
    n : (int, int)
        Points of the surface.
    free : (bool, bool)
        Whether it ends along x, along y.
    sizes : (float, float)

    Returns
    -------
    (int, int)
    """
    from scipy.fft import next_fast_len

    space = FREE_SPACE
    axes = list(zip(n, sizes, free))
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
            needed = max([*beside, min(length**2 / (space.slender * size), length / 2)]) * k / size
            mean = (k * (longest * k / size) ** 2) ** (1 / 3)
            beyond = max(k * space.share, space.of_longest * mean, space.points, needed)
            step = 16 if k + beyond > 128 else 4  # the levels halve it
            longer = step * int(next_fast_len(-(-(k + math.ceil(beyond)) // step), real=True))
        cell.append(longer)
    return tuple(cell)


def grid_of(
    n: tuple, sizes: tuple[float, ...], comm: Any, free: tuple[bool, bool], threads: int = 1
) -> Grid:
    """Make the grid on which a surface is solved.

    Parameters
    ----------
    n : (int, int)
        Points of the surface.
    sizes : (float, float)
    comm : Comm
    free : (bool, bool)
        Whether it ends along x, along y.
    threads : int

    Returns
    -------
    Grid
    """
    cell = cell_of(n, free, sizes)
    whole = tuple(size * m / k for size, m, k in zip(sizes, cell, n))
    return Grid.kept(cell, whole, comm, threads, nominal=n)


def nominal_part(grid: Grid) -> Grid:
    """Return the grid of the nominal area alone, whose rows lie on the same ranks."""
    if not grid.padded:
        return grid
    starts = np.minimum(grid.starts, grid.nominal[0])
    return Grid.kept(grid.nominal, grid.nominal_sizes, grid.comm, grid.threads, starts)
