"""Points without a height, filled harmonically: each is the mean of its neighbours, as a soap film
over the hole would lie."""

from dataclasses import replace
from typing import Any

import numpy as np

from ..parallel.guard import on_rank_0
from ..util.errors import SceneError
from .slabs import local, own_slabs, with_neighbours
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
    return points, _harmonic(points, neighbours, known, found.n[1])


def _holes(found: Topography, comm: Any) -> tuple[np.ndarray, ...]:
    """This rank's points without a height by their numbers, how many neighbours each has, and the
    sum of the heights of those known."""
    parts = [(np.zeros(0, np.int64), np.zeros(0), np.zeros(0))]
    for start, stop in own_slabs(found.n[0], comm):
        if np.isnan(found.rows(start, stop)).any():
            around = with_neighbours(found, start, stop, constant_values=np.inf)  # nothing there
            i, j = np.nonzero(np.isnan(around[1:-1, 1:-1]))
            beside = np.array([around[i + 1 + di, j + 1 + dj] for di, dj in NEIGHBOURS])
            there = (beside != np.inf).sum(axis=0)
            known = np.where(np.isfinite(beside), beside, 0).sum(axis=0)
            parts.append(((start + i) * found.n[1] + j, there, known))
    return tuple(np.concatenate(part) for part in zip(*parts))


def _harmonic(
    points: np.ndarray, neighbours: np.ndarray, known: np.ndarray, n_y: int
) -> np.ndarray:
    """Heights of the points: neighbours*z - (sum of z of the neighbours that are missing, too) =
    known."""
    if not len(points):
        return known
    from scipy.sparse import coo_array, diags_array  # 50 MB that a run without holes does without
    from scipy.sparse.linalg import spsolve

    beside = [(points[points % n_y < n_y - 1], 1), (points, n_y)]
    pairs = [np.intersect1d(some, points - step) for some, step in beside]
    links = [np.searchsorted(points, (pair, pair + step)) for pair, (_, step) in zip(pairs, beside)]
    row, column = np.concatenate([side for one in links for side in (one, one[::-1])], axis=1)
    matrix = diags_array(neighbours.astype(float)) - coo_array(
        (np.ones(len(row)), (row, column)), shape=(len(points),) * 2
    )
    return np.atleast_1d(spsolve(matrix.tocsc(), known))
