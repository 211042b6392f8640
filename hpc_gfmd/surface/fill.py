"""Missing heights, filled as by a soap film: each is the mean of its four neighbours."""

import numpy as np

from ..util.errors import SceneError
from .film import solve_film
from .topography import Topography

NEIGHBOURS = np.array([(-1, 0), (1, 0), (0, -1), (0, 1)])


def filled(topography: Topography, how: str) -> Topography:
    """Return a copy of a map with missing heights filled ("harmonic") or refused ("none"); the map
    itself if none is missing.

    Raises SceneError also if all are missing, or if memory does not suffice.
    """
    z = topography.heights()
    missing = np.isnan(z)
    i, j = np.nonzero(missing)
    if not len(i):
        return topography
    if how == "none" or missing.all():
        raise SceneError(
            f"surface.path: found nan at ({i[0]}, {j[0]}) in {topography.path}, {len(i)} points"
            ' without a height, allowed: finite heights, or fill = "harmonic" where some are known'
        )
    # At an edge a point takes the place of its neighbour beyond, and so counts as missing.
    last_i, last_j = (k - 1 for k in z.shape)
    beside = np.array(
        [z[(i + di).clip(0, last_i), (j + dj).clip(0, last_j)] for di, dj in NEIGHBOURS]
    ).T
    z = z.copy()
    try:
        z[missing] = _film(z.shape, i * z.shape[1] + j, beside)
    except MemoryError:
        raise SceneError(
            f"surface.fill: not enough memory to fill {len(i)} points of {topography.path},"
            " allowed: smaller holes, surface.crop, or more memory"
        ) from None
    line = f"{len(i)} points ({100 * len(i) / z.size:.2g} %) filled"
    return topography.of_heights(z, line, filled=len(i))


def _film(n: tuple[int, ...], points: np.ndarray, beside: np.ndarray) -> np.ndarray:
    """Compute the heights of missing points, each the mean of its four neighbours; beyond an edge a
    point is its own neighbour.

    points: indices i n_y + j, ascending. beside: the four heights around each, in the order of
    NEIGHBOURS, nan where they are missing too.
    """
    from scipy.sparse import coo_array, eye_array  # 50 MB that a run without holes does without

    row, side = np.nonzero(np.isnan(beside))
    missing = np.add(np.unravel_index(points[row], n), NEIGHBOURS[side].T)
    column = np.searchsorted(points, np.ravel_multi_index((*missing,), n, mode="clip"))
    sums = coo_array((np.ones(len(row)), (row, column)), shape=(len(points),) * 2)
    matrix = len(NEIGHBOURS) * eye_array(len(points)) - sums
    x, y = np.unravel_index(points, n)
    return solve_film(matrix.tocsr(), np.nansum(beside, axis=1), x, y)
