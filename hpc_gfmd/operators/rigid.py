"""Rigid moves of a body with a hardness: it sinks or rises as a whole, at no elastic cost, and
dents the surface.

The contact carries at least H times the points with a dent and at most H times all points that
touch. The energy is piecewise linear in the height of the body; its minimum is where the n-th
smallest gap becomes 0, n being the load over H, rounded up.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..kernels.selection import depths_below
from ..parallel.threads import added
from .selection import nth_smallest

if TYPE_CHECKING:
    from .problem import Problem


def points_to_carry(problem: Problem, p0: float) -> int:
    """Return how many points with the pressure H carry a load: load/H, rounded up, at least 1."""
    hardness = problem.hardness or np.inf
    N = problem.grid.N
    return min(max(int(np.ceil(N * p0 / hardness)), 1), N)


def balancing_shift(problem: Problem, p0: float, g: np.ndarray) -> tuple[np.floating, float]:
    """Return by how much to lower the gap so that the contact carries p0, and the energy it frees.

    The shift, below 0 if the body must rise, is in the precision of g, which stays as it is; the
    energy is summed over points. Collective.
    """
    grid = problem.grid
    shift = nth_smallest(grid, lambda i0, i1: g[i0:i1], points_to_carry(problem, p0))
    rows, points = grid.inside

    def depths(i0: int, i1: int) -> tuple[float, float]:
        return depths_below(g[i0:i1], (i1 - i0, points), shift)

    before, after = grid.comm.sum(added(grid.by_rows(depths, rows), 2)).tolist()
    return shift, grid.N * p0 * float(shift) - (problem.hardness or 0.0) * (after - before)


def dent_rigidly(
    problem: Problem, p0: float, p_cell: float, g: np.ndarray, p: np.ndarray, uKu: float
) -> bool:
    """Replace a state by a rigid body that dents the surface, if that has less energy. Collective.

    States that come from a coarser grid or a clipped plane, without a hardness, have pressures far
    beyond it; a rigid body has a uniform pressure, the load. p0 is over the surface, p_cell over
    the grid, uKu that of the state. Returns whether g and p were overwritten; never without stored
    heights or without a hardness.
    """
    h, hardness = problem.stored, problem.hardness
    if h is None or hardness is None:
        return False
    grid = problem.grid
    rows, points = grid.inside
    level = nth_smallest(grid, lambda i0, i1: h[i0:i1], points_to_carry(problem, p0))

    def sums(i0: int, i1: int) -> tuple[float, float, float]:
        inner = max(min(i1, rows) - i0, 0)
        heights = h[i0 : i0 + inner]
        dents, _ = depths_below(g[i0 : i0 + inner], (inner, points), 0.0)
        _, rigid_dents = depths_below(heights, (inner, points), level)
        return g[i0:i1].sum(dtype=float) - heights.sum(dtype=float), dents, rigid_dents

    u, dents, rigid_dents = grid.comm.sum(added(grid.by_rows(sums), 3)).tolist()
    energy = 0.5 * uKu + p_cell * u + hardness * dents
    rigid_energy = -grid.N * p0 * float(level) + hardness * rigid_dents
    if not rigid_energy < energy:
        return False

    def lay(i0: int, i1: int) -> None:
        inner = max(min(i1, rows) - i0, 0)
        g[i0:i1] = -level
        g[i0 : i0 + inner, :points] += h[i0 : i0 + inner]
        p[i0:i1] = p_cell

    grid.by_rows(lay)
    return True
