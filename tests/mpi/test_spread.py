"""Coarse levels and coarse grids that are spread over the ranks, with large grids or low limits."""

import pytest
from contacts import EXACT, rough
from mpi.same import assert_same, sweeps

from hpc_gfmd.driver import decimation
from hpc_gfmd.operators import hierarchy

pytestmark = pytest.mark.mpi
LARGE = rough((2, 150, 2), seed=5)  # 600 x 600


def spread_levels(sweep):
    """Return the number of distributed levels of the preconditioner, and of distributed coarse
    grids of the nested start."""
    grids = len([coarse for coarse in sweep.working.nested().grids if coarse.comm.size > 1])
    # a rank may have no part in the last ones
    return sweep.starter.solver.levels.distributed, int(sweep.surface.grid.comm.max([grids])[0])


def compare_all(comm, surface, loads, **solver):
    """Compare loads on all ranks with those on one process; return the sweep on all ranks."""
    pair = sweeps(comm, surface, **solver)
    for p_star in loads:
        steps = [sweep.solve(p_star * sweep.surface.g_rms) for sweep in pair]
        assert steps[0].status == "converged"
        assert_same(comm, *steps, 1e-9)
    return pair[0]


def test_large_grid(comm):
    """One load with a nested start."""
    if comm.size == 1:
        pytest.skip("needs several ranks")
    sweep = compare_all(comm, LARGE, [0.1], accuracy=1e-2, precision="double")
    assert spread_levels(sweep) == (2, 2)


@pytest.mark.parametrize(
    "surface",
    [
        rough(),
        rough((1, 31, 2.0), seed=3),
        rough((2, 8, 3), hurst=0.3, physical_sizes=[1.0, 0.5]),
        rough((1, 47, 2), hurst=1.0),
    ],
)
def test_small_limits(comm, surface, monkeypatch):
    """The same code on small grids, where solutions can be exact."""
    monkeypatch.setattr(hierarchy, "COARSEST_POINTS", 16)
    monkeypatch.setattr(hierarchy, "UNGATHERED_POINTS", 16)
    monkeypatch.setattr(hierarchy, "FEWEST_ROWS", 4)
    monkeypatch.setattr(decimation, "RANK_POINTS", 64)
    monkeypatch.setattr(decimation, "COARSEST", 8)
    sweep = compare_all(comm, surface, [0.02, 0.3], **EXACT)
    levels, grids = spread_levels(sweep)
    assert levels >= 2 or comm.size == 1
    assert grids >= 1 or comm.size == 1
