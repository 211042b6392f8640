"""The self-energy of a surface with free edges bounds what it says, closely."""

import numpy as np
import pytest

from hpc_gfmd.bodies import body_of
from hpc_gfmd.operators.elastic import Elastic
from hpc_gfmd.operators.problem import self_energy
from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.scene import Material
from hpc_gfmd.surface.cell import grid_of


@pytest.mark.parametrize("sizes", [(1.0, 1.0), (4.0, 1.0), (1.0, 16.0)])
@pytest.mark.parametrize("n", [(24, 20), (256, 256)])  # in cells of 4 and 1.5 times the width
@pytest.mark.parametrize("free", [(True, True), (True, False), (False, True), (False, False)])
def test_bound(free, n, sizes):
    grid = grid_of(n, sizes, SerialComm(), free)
    elastic = Elastic(grid, body_of(Material(), free), np.float64)
    nominal = np.zeros(grid.n)
    nominal[: n[0], : n[1]] = 1

    def fill(i0, i1, x):
        x[: i1 - i0] = nominal[i0:i1] - nominal.mean()

    elastic.pressure_rows(fill)
    energy = elastic.columns(inverse=True, backward=False)
    assert np.sqrt(energy) <= self_energy(grid) <= 4 * np.sqrt(energy)
