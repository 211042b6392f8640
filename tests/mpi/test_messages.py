"""What ranks send in an iteration is what was planned for each of them, to the byte."""

import pytest
from contacts import rough, sweep_of

from hpc_gfmd.driver.decomposition import Share
from hpc_gfmd.operators import multilevel

pytestmark = pytest.mark.mpi


@pytest.mark.parametrize("boundary", ["periodic", "free"])
@pytest.mark.parametrize("n_over", [(2, 32, 4), (1, 31, 2.0)], ids=["256x256", "62x62"])
def test_counted(comm, n_over, boundary, monkeypatch):
    monkeypatch.setattr(multilevel, "COARSEST_POINTS", 64)
    monkeypatch.setattr(multilevel, "RANK_POINTS", 256)
    sweep = sweep_of(rough(n_over, boundary=boundary), comm=comm, accuracy=1e-2, precision="single")
    sweep.solve(0.1 * sweep.surface.g_rms)
    if comm.size == 1:
        return
    before = comm.sent.bytes, comm.sent.messages
    sweep.solver.step()
    share = Share(sweep.surface.grid, sweep.dtype)
    assert (comm.sent.bytes - before[0], comm.sent.messages - before[1]) == share.traffic
    assert all(sent > 0 for sent in (*share.transpose_traffic, *share.level_traffic, *share.reduction_traffic))
