"""The grid on which a surface is solved: longer than the surface along axes with free edges."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..bodies.images import NEEDED
from ..parallel.grid import Grid


@dataclass(frozen=True)
class FreeSpace:
    """Empty space beyond free edges: the largest of these lengths, which were measured by what more
    space changes (tests/physics/test_free.py).
    """

    share: float = 1 / 2  # in units of the length of the axis
    # In units of (length of the axis times the square of the longest side with free edges)^(1/3),
    # which limits the number of coupled modes (bodies/free.py).
    of_longest: float = 0.42
    points: int = 64  # in grid points
    # in grid spacings of any axis with free edges, to resolve these modes
    spacings: float = 2 * NEEDED
    periodic_spacings: int = 4  # in grid spacings of any other axis that has more than one point
    # The square of the longest side over the product of a side and the space beyond it is at most
    # this, since otherwise S (bodies/free.py) would not be positive. A space of half of the longest
    # side suffices in any case.
    slender: int = 256


FREE_SPACE = FreeSpace()


def cell_of(n: tuple, free: tuple[bool, bool], sizes: tuple[float, ...]) -> tuple:
    """Return the grid points, fast to transform, of a surface with the space beyond free edges."""
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
            from scipy.fft import next_fast_len  # takes a tenth of a second

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
    """Make the grid of a surface; it may share scratch memory with earlier ones (`Grid.kept`)."""
    cell = cell_of(n, free, sizes)
    whole = tuple(size * m / k for size, m, k in zip(sizes, cell, n))
    return Grid.kept(cell, whole, comm, threads, nominal=n)


def nominal_part(grid: Grid) -> Grid:
    """Return the grid of the nominal area alone, its rows on the same ranks as in `grid`."""
    if not grid.padded:
        return grid
    starts = np.minimum(grid.starts, grid.nominal[0])
    return Grid.kept(grid.nominal, grid.nominal_sizes, grid.comm, grid.threads, starts)
