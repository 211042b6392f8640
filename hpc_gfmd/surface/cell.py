"""The grid on which a surface is solved: longer than the surface along axes with free edges."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..bodies.images import NEEDED
from ..parallel.grid import Grid


@dataclass(frozen=True)
class FreeSpace:
    """Empty space that the grid has along an axis beyond a surface with free edges.

    It is the largest of the lengths that these numbers give. They were measured by what more space
    changes, see tests/physics/test_free.py.

    Attributes
    ----------
    share : float
        In units of the length of the axis.
    of_longest : float
        In units of (length of the axis times the square of the longest side with free edges)^(1/3),
        which limits the number of coupled modes (bodies/free.py).
    points : int
        In grid points.
    spacings : float
        In grid spacings of any axis with free edges, to resolve these modes.
    periodic_spacings : int
        In grid spacings of any other axis that has more than one point.
    slender : int
        The square of the longest side over the product of a side and the space beyond it is at most
        this, since otherwise S, the displacements per pressure (bodies/free.py), would not be
        positive. A space of half of the longest side suffices in any case.
    """

    share: float = 1 / 2
    of_longest: float = 0.42
    points: int = 64
    spacings: float = 2 * NEEDED
    periodic_spacings: int = 4
    slender: int = 256


FREE_SPACE = FreeSpace()


def cell_of(n: tuple, free: tuple[bool, bool], sizes: tuple[float, ...]) -> tuple:
    """Return the grid points along each axis on which a surface is solved.

    Parameters
    ----------
    n : (int, int)
        Points of the surface.
    free : (bool, bool)
        Whether the edges are free along x, along y.
    sizes : (float, float)
        (L_x, L_y) of the surface.

    Returns
    -------
    (int, int)
        n along periodic axes; along axes with free edges more, a number that is fast to transform.
    """
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
    """Make the grid on which a surface is solved, with empty space beyond free edges.

    Parameters
    ----------
    n : (int, int)
        Points of the surface.
    sizes : (float, float)
        (L_x, L_y) of the surface.
    comm : Comm
        All ranks that share the rows.
    free : (bool, bool)
        Whether the edges are free along x, along y.
    threads : int
        Threads of this rank.

    Returns
    -------
    Grid
        Its nominal area is the surface. It may share scratch memory with earlier grids of its size
        (`Grid.kept`).
    """
    cell = cell_of(n, free, sizes)
    whole = tuple(size * m / k for size, m, k in zip(sizes, cell, n))
    return Grid.kept(cell, whole, comm, threads, nominal=n)


def nominal_part(grid: Grid) -> Grid:
    """Return the grid of the nominal area alone, with rows on the same ranks as in `grid`.

    This is `grid` itself if it is not padded.
    """
    if not grid.padded:
        return grid
    starts = np.minimum(grid.starts, grid.nominal[0])
    return Grid.kept(grid.nominal, grid.nominal_sizes, grid.comm, grid.threads, starts)
