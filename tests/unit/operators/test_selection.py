"""The n-th smallest number of a field against a sorted copy."""

import numpy as np
import pytest

from hpc_gfmd.operators.selection import nth_smallest
from hpc_gfmd.parallel.grid import Grid


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("scale", [1e-30, 1.0, 1e30])
def test_all_orders_of_a_field_with_ties(dtype, scale):
    random = np.random.default_rng(0)
    grid = Grid((12, 10))
    field = (scale * np.round(random.standard_normal(grid.shape), 1)).astype(dtype)
    field[0, :3] = 0, -0.0, np.finfo(dtype).tiny
    wanted = np.sort(field.ravel())
    for n in range(1, grid.N + 1):
        assert nth_smallest(grid, lambda i0, i1: field[i0:i1], n) == wanted[n - 1]


def test_points_outside_the_surface_are_ignored():
    random = np.random.default_rng(0)
    grid = Grid((12, 10), nominal=(7, 6))
    field = random.standard_normal(grid.shape)
    field[7:] = field[:, 6:] = -9.0
    wanted = np.sort(field[:7, :6].ravel())
    for n in (1, grid.N):
        assert nth_smallest(grid, lambda i0, i1: field[i0:i1], n) == wanted[n - 1]
