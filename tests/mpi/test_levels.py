"""The preconditioner on slabs is that of one process, also its gap mode, wherever its level is."""

import numpy as np
import pytest

from hpc_gfmd.bodies.halfspace import HALF_SPACE
from hpc_gfmd.operators import hierarchy
from hpc_gfmd.operators.multilevel import Multilevel
from hpc_gfmd.parallel.grid import Grid

pytestmark = pytest.mark.mpi


def contact(n):
    """(g, p) of a few patches: a gap mode counts where little touches."""
    random = np.random.default_rng(3)
    g = random.random(n) + 0.1
    g[20:50, 60:90] = 0.0
    g[150:160, 10:30] = 0.0
    return g, random.standard_normal(n) + 0.5


def swept(comm, n, g, p, coarsest=None):
    """z on level 1, all rows, and the sums of two sweeps: of a new contact, and of another p."""
    grid = Grid(n, comm=comm)
    levels = Multilevel(grid, HALF_SPACE, np.float64, 8, coarsest)
    mine = slice(*grid.rows)
    results = []
    for pressure, new_share in ((p, np.mean(g <= 0)), (np.roll(p, 7, 0), None)):
        levels.restrict(g[mine], np.where(g > 0, pressure, 1.0)[mine])
        sums = levels.sweep(new_share)
        transfer = levels.transfers[0]
        m_x = transfer.m[0]
        rows = np.arange(transfer.lo[transfer.rank], transfer.hi[transfer.rank]) % m_x
        whole = np.empty((m_x, transfer.m[1]))
        for rows_of_rank, z in grid.comm.allgather((rows, levels.z[1 : 1 + len(rows)])):
            whole[rows_of_rank] = z
        results += [whole, grid.comm.sum(sums)]
    return results, levels


@pytest.mark.parametrize("fewest_rows", [2, 16])
@pytest.mark.parametrize(
    ("n", "coarsest"), [((256, 256), 64), ((256, 256), 4096), ((300, 200), 64)]
)
def test_sweep_is_that_of_one_process(comm, n, coarsest, fewest_rows, monkeypatch):
    """With levels on slabs or gathered, also on one process, down to that of the gap mode."""
    g, p = contact(n)
    alone, _ = swept(None, n, g, p)
    monkeypatch.setattr(hierarchy, "UNGATHERED_POINTS", coarsest)
    monkeypatch.setattr(hierarchy, "FEWEST_ROWS", fewest_rows)
    on_ranks, levels = swept(comm, n, g, p, coarsest)
    for mine, expected in zip(on_ranks, alone, strict=True):
        assert np.allclose(mine, expected, rtol=1e-10, atol=1e-12 * np.abs(expected).max())
    if coarsest == 64:
        assert levels.distributed == levels.gap_mode.level - 1 > 0
