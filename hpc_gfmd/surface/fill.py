"""Missing heights, filled harmonically.

Each is the mean of its four neighbours, so that holes are closed as by a soap film.
"""

import numpy as np

from ..util.errors import SceneError
from .film import solve_film
from .topography import Topography

NEIGHBOURS = ((-1, 0), (1, 0), (0, -1), (0, 1))


def filled(topography: Topography, how: str) -> Topography:
    """Return a map without missing heights, with a line in `prepared`; itself if none is missing.

    how: "harmonic", or "none" to refuse missing heights. SceneError if these are refused, if all
    are missing, or if memory does not suffice.
    """
    z = topography.heights()
    missing = np.isnan(z)
    count = int(np.count_nonzero(missing))
    if count == 0:
        return topography
    if how == "none" or count == z.size:
        i, j = np.unravel_index(missing.argmax(), z.shape)
        raise SceneError(
            f"surface.path: found nan at ({i}, {j}) in {topography.path}, {count} points"
            ' without a height, allowed: finite heights, or fill = "harmonic" where some are known'
        )
    z = z.copy()
    try:
        z[missing] = _film(z, missing)
    except MemoryError:
        raise SceneError(
            f"surface.fill: not enough memory to fill {count} points of {topography.path}, allowed:"
            " smaller holes, surface.crop, or more memory"
        ) from None
    line = f"{count} points ({100 * count / z.size:.2g} %) filled"
    return topography.of_heights(z, line, filled=count)


def _film(z: np.ndarray, missing: np.ndarray) -> np.ndarray:
    """Return the heights of missing points, each the mean of its four neighbours.

    For each point the equation is 4 z - (sum of z of missing neighbours) = sum of the other
    neighbours, where beyond an edge the point is its own neighbour.
    """
    from scipy.sparse import csr_array  # 50 MB that a run without holes does without

    x, y = (place.astype(np.int32) for place in np.nonzero(missing))
    points = np.arange(x.size, dtype=np.int32)
    number = np.zeros(z.shape, np.int32)  # of a point among the missing ones
    number[missing] = points
    columns = np.repeat(points[:, None], 5, axis=1)
    factors = np.zeros((x.size, 5))
    factors[:, 4] = 4.0
    right = np.zeros(x.size)
    for k, (dx, dy) in enumerate(NEIGHBOURS):
        beside = np.clip(x + dx, 0, z.shape[0] - 1), np.clip(y + dy, 0, z.shape[1] - 1)
        is_unknown = missing[beside]
        columns[is_unknown, k] = number[beside][is_unknown]
        factors[is_unknown, k] = -1.0
        right += np.where(is_unknown, 0.0, z[beside])
    starts = np.arange(0, columns.size + 1, 5)
    matrix = csr_array((factors.ravel(), columns.ravel(), starts), shape=(x.size, x.size))
    matrix.sum_duplicates()
    return solve_film(matrix, right, x, y)
