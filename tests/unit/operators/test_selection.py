"""The n-th smallest number of a field against a sorted copy."""

import numpy as np
import pytest

from hpc_gfmd.operators.selection import nth_smallest
from hpc_gfmd.parallel.grid import Grid


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("scale", [1e-30, 1.0, 1e30])
@pytest.mark.parametrize("nominal", [(12, 10), (7, 6)])
def test_all_orders_of_a_field_with_ties(nominal, dtype, scale):
    """Points outside the surface are ignored."""
    random = np.random.default_rng(0)
    grid = Grid((12, 10), nominal=nominal)
    field = (scale * np.round(random.standard_normal(grid.shape), 1)).astype(dtype)
    field[0, :3] = 0, -0.0, np.finfo(dtype).tiny
    wanted = np.sort(field[: nominal[0], : nominal[1]].ravel())
    for n in range(1, grid.N + 1):
        assert nth_smallest(grid, lambda i0, i1: field[i0:i1], n) == wanted[n - 1]
