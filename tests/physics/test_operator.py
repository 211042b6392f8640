"""K = (E*/2)|q| on single modes: physics to 1e-12 on every kind of grid."""

import numpy as np
import pytest
from transfers import stiffness_times

from hpc_gfmd.bodies.halfspace import HalfSpace
from hpc_gfmd.operators.elastic import Elastic
from hpc_gfmd.parallel.grid import Grid

GRIDS = [
    ((16, 16), (1.0, 1.0)),
    ((15, 15), (1.0, 1.0)),
    ((16, 15), (1.0, 1.0)),
    ((9, 20), (2.0, 0.7)),
    ((1, 12), (1.0, 1.0)),
    ((13, 1), (1.0, 1.0)),
    ((2, 2), (1.0, 3.0)),
    ((17, 23), (3.0, 3.0)),
]


def modes(n):
    """Lowest, middle and highest mode numbers of an axis, Nyquist included."""
    return sorted({0, 1 % n, n // 3, n // 2})


@pytest.mark.parametrize(("n", "sizes"), GRIDS)
def test_single_modes(n, sizes):
    grid = Grid(n, sizes)
    elastic = Elastic(grid, HalfSpace(), np.float64)
    x, y = np.meshgrid(np.arange(n[0]) / n[0], np.arange(n[1]) / n[1], indexing="ij")
    for k_x in modes(n[0]):
        for k_y in modes(n[1]):
            for sign in (1, -1):
                u = np.cos(2 * np.pi * (k_x * x + sign * k_y * y))
                q = 2 * np.pi * np.hypot(k_x / sizes[0], k_y / sizes[1]) * grid.a
                out = grid.empty(np.float64)
                uKu = stiffness_times(elastic, u, out)
                assert np.abs(out - q / 2 * u).max() <= 1e-12 * max(q, 1)
                assert uKu == pytest.approx(q / 2 * np.vdot(u, u), rel=1e-12, abs=1e-12)
