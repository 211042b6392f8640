"""Missing heights, filled harmonically.

Each is the mean of its four neighbours, so that holes are closed as by a soap film.
"""

from itertools import chain
from typing import Any

import numpy as np

from ..parallel.guard import collective_errors, on_rank_0
from ..util.errors import SceneError
from .film import solve_film
from .slabs import with_neighbours
from .topography import Topography

NEIGHBOURS = np.array([(-1, 0), (1, 0), (0, -1), (0, 1)])


def filled(topography: Topography, how: str, comm: Any) -> Topography:
    """Fill the missing heights of a map. Collective.

    Parameters
    ----------
    topography : Topography
        Not changed.
    how : str
        "harmonic", or "none" to refuse missing heights.
    comm : Comm

    Returns
    -------
    Topography
        A copy whose `rows` reads the given map and puts in the missing heights, which every rank
        keeps; its `prepared` has a line on that. topography itself if no height is missing.

    Raises
    ------
    SceneError
        On all ranks: if heights are missing and how is "none", if all are missing, or if memory
        does not suffice.
    """
    with collective_errors(comm, "reading the surface"):
        holes = _holes(topography, comm)
    parts = comm.gather(holes)
    points, heights = on_rank_0(
        comm, "filling the surface", lambda: _heights(topography, how, parts)
    )
    if not len(points):
        return topography

    def rows(start: int, stop: int) -> np.ndarray:
        z = np.array(topography.rows(start, stop))
        begin, end = np.searchsorted(points, [start * topography.n[1], stop * topography.n[1]])
        z[np.isnan(z)] = heights[begin:end]
        return z

    share = 100 * len(points) / np.prod(topography.n)
    line = f"{len(points)} points ({share:.2g} %) filled"
    return topography.after(line, rows=rows, filled=len(points))


def _holes(topography: Topography, comm: Any) -> list[tuple[np.ndarray, np.ndarray]]:
    """Find the missing heights in this rank's share of a map. Not collective.

    Returns (points, beside) for each piece of rows: points are the indices i n_y + j of missing
    heights, beside[k] the four heights around point k, in the order of NEIGHBOURS, nan where they
    are missing too. At an edge of the map the point itself takes the place of its neighbour, and
    so counts as missing.
    """
    parts = []
    for start, around in with_neighbours(topography, comm, "edge"):
        i, j = np.nonzero(np.isnan(around[1:-1, 1:-1]))
        beside = np.array([around[i + 1 + di, j + 1 + dj] for di, dj in NEIGHBOURS])
        parts.append(((start + i) * topography.n[1] + j, beside.T))
    return parts


def _heights(topography: Topography, how: str, parts: list) -> tuple[np.ndarray, np.ndarray]:
    """Return indices i n_y + j of all missing points, ascending, and the heights that fill them.

    Both are empty if no height is missing. how: as for `filled`. parts: what `_holes` returned on
    each rank. Raises SceneError as `filled`. Called on rank 0.
    """
    points, beside = map(np.concatenate, zip(*chain(*parts)))
    n_y = topography.n[1]
    if not len(points):
        return points, beside
    if how == "none" or len(points) == topography.n[0] * n_y:
        i, j = divmod(int(points[0]), n_y)
        raise SceneError(
            f"surface.path: found nan at ({i}, {j}) in {topography.path}, {len(points)} points"
            ' without a height, allowed: finite heights, or fill = "harmonic" where some are known'
        )
    try:
        return points, _film(topography.n, points, beside)
    except MemoryError:
        raise SceneError(
            f"surface.fill: not enough memory to fill {len(points)} points of {topography.path},"
            " allowed: smaller holes, surface.crop, or more memory"
        ) from None


def _film(n: tuple[int, ...], points: np.ndarray, beside: np.ndarray) -> np.ndarray:
    """Compute the heights of missing points, each the mean of its four neighbours.

    n: points along x and y. points, beside: those of `_holes` on all ranks, points ascending. For
    each point the equation is 4 z - (sum of z of missing neighbours) = sum of the other neighbours,
    where beyond an edge the point is its own neighbour.
    """
    from scipy.sparse import coo_array, eye_array  # 50 MB that a run without holes does without

    row, side = np.nonzero(np.isnan(beside))
    missing = np.add(np.unravel_index(points[row], n), NEIGHBOURS[side].T)
    column = np.searchsorted(points, np.ravel_multi_index((*missing,), n, mode="clip"))
    sums = coo_array((np.ones(len(row)), (row, column)), shape=(len(points),) * 2)
    matrix = len(NEIGHBOURS) * eye_array(len(points)) - sums
    x, y = np.unravel_index(points, n)
    return solve_film(matrix.tocsr(), np.nansum(beside, axis=1), x, y)
