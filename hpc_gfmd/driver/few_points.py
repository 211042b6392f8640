"""Light contacts are solved on the few points that can touch, by the matrix of S between them.

These are the points near the wall in the start from coarser grids, or at the load before. The
pressure of those in contact follows from g = 0; those with p < 0 leave, those with g < 0 join,
until none does: an active set method, exact but for rounding. One application of S then gives the
gap on the whole surface (certificate/of_pressure.py). If other points penetrate they are added, and
all is solved again.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..certificate.of_pressure import Part
from ..operators.influence import between, influence
from ..parallel import interrupt

if TYPE_CHECKING:
    from ..operators.problem import Problem

# Points that can touch, over the cube root of the grid's, up to which this is faster than
# iterations: the factors of the matrix take the cube of their number. Measured on self-affine walls
# of 64 to 1024 points: both take the same time at 13 to 16, and from 16 on with free edges.
MOST = 14.0
LARGEST = 2**23  # points of a grid whose table of S is made; chosen: it takes at most 64 MiB
# Points can touch that are closer to the wall than so many times the gap which the mean pressure of
# those in contact makes at a single point. Measured: at 0.05 other points penetrate on every second
# wall, at 0.2 on one of seven, at 0.5 on none, with 1.4 times as many points.
NEAR = 0.4
CHANGES = 12  # of the set in contact; chosen: it settles after 2 to 5


class FewPoints(NamedTuple):
    """This rank's points that can touch."""

    rows: np.ndarray  # local
    columns: np.ndarray
    closed: np.ndarray  # bool, which are in contact as far as known

    @classmethod
    def near(cls, problem: Problem, g: np.ndarray) -> FewPoints | None:
        """Return the points near the wall in a gap (local slab); None if none touches or too many
        do. Collective.
        """
        grid = problem.grid
        if grid.cell_points > LARGEST:
            return None
        rows, columns = grid.inside
        gap = g[:rows, :columns]
        touching = grid.comm.sum([np.count_nonzero(gap <= 0)])[0]
        many = MOST * grid.cell_points ** (1 / 3)
        if not 0 < touching < many:
            return None
        pressure = problem.p0 * grid.N / touching
        limit = NEAR * pressure * problem.body.point_compliance(grid)
        where = np.nonzero(gap <= limit)
        few = cls(where[0], where[1], gap[where] <= 0)
        return few if grid.comm.sum([few.rows.size])[0] < many else None

    @classmethod
    def solved(cls, problem: Problem, g: np.ndarray) -> Part | None:
        """Return the contact on the points near the wall in a gap (local slab); None if none or too
        many touch, or the set in contact does not settle. Collective.
        """
        few = cls.near(problem, g)
        if few is None:
            return None
        grid = problem.grid
        comm = grid.comm
        S = influence(grid, problem.body, problem.dtype)
        h = problem.heights[few.rows, few.columns].astype(np.float64)
        points = comm.gather((few.rows + grid.rows[0], few.columns, h, few.closed))
        with interrupt.shared(comm, None) as found:
            if points is not None:
                i, j, heights, closed = map(np.concatenate, zip(*points))
                matrix = between(grid, S, i, j)
                found.value = _pressure(matrix, heights, grid.N * problem.p0, closed)
        if found.value is None:
            return None
        begin = sum(comm.allgather(few.rows.size)[: comm.rank])
        p = found.value[begin : begin + few.rows.size]
        return Part(few.rows, few.columns, p, p > 0)


def _pressure(S: np.ndarray, h: np.ndarray, load: float, closed: np.ndarray) -> np.ndarray | None:
    """Return the pressure of a load on points: p >= 0, g = S p + h - level >= 0, p g = 0. `closed`:
    a guess of the points in contact. None if it does not settle.
    """
    from scipy.linalg import LinAlgError, cho_factor, cho_solve

    for _ in range(CHANGES):
        touching = np.flatnonzero(closed)
        right = np.stack([h[touching], np.ones(len(touching))], axis=1)
        among = S.take(touching, axis=0).take(touching, axis=1).T  # as LAPACK stores it
        try:
            factor = cho_factor(among, lower=True, overwrite_a=True, check_finite=False)
        except LinAlgError:
            return None
        of_gap, of_level = cho_solve(factor, right).T
        level = (load + of_gap.sum()) / of_level.sum()
        p = np.zeros_like(h)
        p[touching] = level * of_level - of_gap
        g = S @ p + h - level
        before = closed
        closed = np.where(before, p > 0, g < 0)
        if np.array_equal(closed, before):
            return p
    return None
