"""Points without a height, filled harmonically: each is the mean of its neighbours, as a soap film
over the hole would lie."""

from itertools import chain
from typing import Any

import numpy as np

from ..parallel.guard import collective_errors, on_rank_0
from ..util.errors import SceneError
from .slabs import own_slabs, with_neighbours
from .topography import Topography

NEIGHBOURS = np.array([(-1, 0), (1, 0), (0, -1), (0, 1)])


def filled(found: Topography, how: str, comm: Any) -> Topography:
    """Return the Topography without holes. Collective.

    Raises SceneError where holes are not to be filled.
    """
    with collective_errors(comm, "reading the surface"):
        own = _holes(found, comm)
    parts = comm.gather(own)
    points, heights = on_rank_0(comm, "filling the surface", lambda: _heights(found, how, parts))
    if not len(points):
        return found

    def rows(start: int, stop: int) -> np.ndarray:
        z = np.array(found.rows(start, stop))
        first, last = np.searchsorted(points, [start * found.n[1], stop * found.n[1]])
        z[np.isnan(z)] = heights[first:last]
        return z

    said = f"{len(points)} points ({100 * len(points) / np.prod(found.n):.2g} %) filled"
    return found.after(said, rows=rows, filled=len(points))


def _holes(found: Topography, comm: Any) -> list[tuple[np.ndarray, np.ndarray]]:
    """Number this rank's points without a height, a piece of its rows at a time, and return what is
    on the four sides of each: a height, nan where there is none. Beyond the edge of the map is the
    point itself."""
    parts = []
    for start, stop in own_slabs(found, comm):
        around = with_neighbours(found, start, stop, "edge")
        i, j = np.nonzero(np.isnan(around[1:-1, 1:-1]))
        beside = np.array([around[i + 1 + di, j + 1 + dj] for di, dj in NEIGHBOURS])
        parts.append(((start + i) * found.n[1] + j, beside.T))
    return parts


def _heights(found: Topography, how: str, parts: list) -> tuple[np.ndarray, np.ndarray]:
    """Return the points of all ranks without a height, by their numbers, and the heights that they
    get."""
    points, beside = map(np.concatenate, zip(*chain(*parts)))
    n_y = found.n[1]
    if not len(points):
        return points, beside
    if how == "none" or len(points) == found.n[0] * n_y:
        i, j = divmod(int(points[0]), n_y)
        raise SceneError(
            f"surface.path: found nan at ({i}, {j}) in {found.path}, {len(points)} points without a"
            ' height, allowed: finite heights, or fill = "harmonic" where some are known'
        )
    from scipy.sparse import coo_array, eye_array  # 50 MB that a run without holes does without
    from scipy.sparse.linalg import spsolve

    # of each point: 4 z - (sum of z of the neighbours that are missing, too) = sum of the others
    row, side = np.nonzero(np.isnan(beside))
    missing = np.add(np.unravel_index(points[row], found.n), NEIGHBOURS[side].T)
    column = np.searchsorted(points, np.ravel_multi_index((*missing,), found.n, mode="clip"))
    sums = coo_array((np.ones(len(row)), (row, column)), shape=(len(points),) * 2)
    matrix = len(NEIGHBOURS) * eye_array(len(points)) - sums
    return points, np.atleast_1d(spsolve(matrix.tocsc(), np.nansum(beside, axis=1)))
