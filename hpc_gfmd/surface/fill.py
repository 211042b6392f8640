"""Points without a height, filled harmonically: each is the mean of its neighbours, as a soap film
over the hole would lie."""

from dataclasses import replace
from typing import Any

import numpy as np

from ..parallel.guard import on_rank_0
from ..util.errors import SceneError
from .slabs import local, own_slabs
from .topography import Topography

NEIGHBOURS = ((-1, 0), (1, 0), (0, -1), (0, 1))


def filled(found: Topography, how: str, comm: Any) -> tuple[Topography, int]:
    """The Topography without holes, and how many points were missing. Collective.

    Raises SceneError where holes are not to be filled.
    """
    holes = comm.reduce(
        local(comm, lambda: _holes(found, comm)),
        lambda one, next_one: list(map(np.append, one, next_one)),
    )
    points, heights = on_rank_0(comm, "filling the surface", lambda: _filled(found, how, *holes))
    if len(points) == 0:
        return found, 0

    def rows(start: int, stop: int) -> np.ndarray:
        z = np.array(found.rows(start, stop))
        first, last = np.searchsorted(points, [start * found.n[1], stop * found.n[1]])
        z.reshape(-1)[points[first:last] - start * found.n[1]] = heights[first:last]
        return z

    return replace(found, rows=rows), len(points)


def _filled(
    found: Topography, how: str, points: np.ndarray, neighbours: np.ndarray, known: np.ndarray
) -> tuple[np.ndarray, ...]:
    """The points without a height and the heights that they get."""
    if len(points) and (how == "none" or len(points) == found.n[0] * found.n[1]):
        i, j = divmod(int(points[0]), found.n[1])
        raise SceneError(
            f"surface.path: found nan at ({i}, {j}) in {found.path}, {len(points)} points without a"
            ' height, allowed: finite heights, or fill = "harmonic" where some are known'
        )
    return points, _harmonic(points, neighbours, known, found.n) if len(points) else np.zeros(0)


def _holes(found: Topography, comm: Any) -> tuple[np.ndarray, ...]:
    """This rank's points without a height by their numbers, how many neighbours each has, and the
    sum of the heights of those known."""
    parts = [(np.zeros(0, np.int64), np.zeros(0), np.zeros(0))]
    n_x, n_y = found.n
    for start, stop in own_slabs(n_x, comm):
        z = found.rows(start, stop)
        if not np.isnan(z).any():
            continue
        first = max(start - 1, 0)
        around = np.full((stop - start + 2, n_y + 2), np.inf)  # beyond the edge there is nothing
        around[first - start + 1 : min(stop + 1, n_x) - start + 1, 1:-1] = found.rows(
            first, min(stop + 1, n_x)
        )
        i, j = np.nonzero(np.isnan(z))
        beside = np.array([around[i + 1 + di, j + 1 + dj] for di, dj in NEIGHBOURS])
        parts.append(
            (
                (start + i) * n_y + j,
                (beside != np.inf).sum(axis=0),
                np.where(np.isfinite(beside), beside, 0).sum(axis=0),
            )
        )
    return tuple(np.concatenate(part) for part in zip(*parts))


def _harmonic(
    points: np.ndarray, neighbours: np.ndarray, known: np.ndarray, n: tuple[int, ...]
) -> np.ndarray:
    """Heights of the points: neighbours*z - (sum of z of the neighbours that are missing, too) =
    known."""
    from scipy.sparse import coo_array, diags_array  # 50 MB that a run without holes does without
    from scipy.sparse.linalg import spsolve

    links = []
    for step, ends in ((1, points % n[1] != n[1] - 1), (n[1], np.full(len(points), True))):
        place = np.searchsorted(points, points + step)
        found = ends & (place < len(points))
        found[found] = points[place[found]] == points[found] + step
        links += [(np.flatnonzero(found), place[found]), (place[found], np.flatnonzero(found))]
    row, column = (np.concatenate(side) for side in zip(*links))
    matrix = diags_array(neighbours.astype(float)) - coo_array(
        (np.ones(len(row)), (row, column)), shape=(len(points),) * 2
    )
    return np.atleast_1d(spsolve(matrix.tocsc(), known))
