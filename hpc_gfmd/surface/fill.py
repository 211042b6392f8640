"""Missing heights, filled harmonically: each is the mean of its four neighbours (a soap film)."""

import numpy as np

from ..util.errors import SceneError
from .film import Film, solve_film
from .topography import Topography

NEIGHBOURS = ((-1, 0), (1, 0), (0, -1), (0, 1))


def filled(topography: Topography, how: str) -> Topography:
    """Return a map without missing heights, by "harmonic"; "none" refuses them with SceneError."""
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
    """Return the missing heights. For each point 4 z - (sum of z of missing neighbours) = sum of
    the others; beyond an edge the point is its own neighbour.
    """
    x, y = (place.astype(np.int32) for place in np.nonzero(missing))
    number = np.full(z.shape, x.size, np.int32)  # of a point among the missing ones
    number[missing] = np.arange(x.size, dtype=np.int32)
    neighbours = []
    diagonal = np.full(x.size, 4, np.float32)
    right = np.zeros(x.size)
    for dx, dy in NEIGHBOURS:
        beside = np.clip(x + dx, 0, z.shape[0] - 1), np.clip(y + dy, 0, z.shape[1] - 1)
        is_itself = (beside[0] == x) & (beside[1] == y)
        diagonal[is_itself] -= 1
        neighbour = number[beside]
        neighbour[is_itself] = x.size
        neighbours.append(neighbour)
        is_known = ~missing[beside]
        right[is_known] += z[beside][is_known]
    del number, beside, is_itself, is_known
    return solve_film(Film(neighbours, diagonal), right, x, y)
