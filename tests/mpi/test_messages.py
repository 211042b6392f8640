"""Ranks send the planned bytes in an iteration; reductions and memory checks."""

import os

import pytest
from contacts import rough, sweep_of
from decomposition import Share, stages
from mpi.nodes import CountingComm, sent_in_a_step

from hpc_gfmd.operators import hierarchy
from hpc_gfmd.runs import capacity
from hpc_gfmd.runs.capacity import require_memory
from hpc_gfmd.scene import Scene
from hpc_gfmd.surface import surface_size
from hpc_gfmd.util.errors import SceneError

pytestmark = pytest.mark.mpi


@pytest.mark.parametrize(("n_over", "boundary"), [((2, 32, 4), "periodic"), ((1, 31, 2.0), "free")])
def test_counted(comm, n_over, boundary, monkeypatch):
    monkeypatch.setattr(hierarchy, "COARSEST_POINTS", 64)
    monkeypatch.setattr(hierarchy, "UNGATHERED_POINTS", 64)
    monkeypatch.setattr(hierarchy, "FEWEST_ROWS", 4)
    if comm.size == 1:
        return
    solver = {"accuracy": 1e-2, "precision": "single"}
    sweep = sweep_of(rough(n_over, boundary=boundary), comm=CountingComm(comm.mpi), **solver)
    sweep.solve(0.1 * sweep.surface.g_rms)
    share = Share(sweep.surface.grid, sweep.dtype)
    assert sent_in_a_step(sweep) == share.traffic
    assert all(sent > 0 for sent in (*share.level_traffic, *share.reduction_traffic))


def test_reduce(comm):
    """It joins in the order of the ranks, with at most log2(ranks) messages for a rank."""
    joined = []

    def join(ranks, next_ranks):
        joined.append(comm.rank)
        return ranks + next_ranks

    result = comm.reduce([comm.rank], join)
    assert result == (list(range(comm.size)) if comm.rank == 0 else None)
    assert len(joined) <= stages(comm.size)


def test_memory_of_a_machine(comm, monkeypatch):
    """Too little memory on a machine is an error on all ranks that names what they need."""
    scene = Scene.from_dict({"surface": rough((1, 16, 2)), "load": {"p_star": [0.1]}})
    monkeypatch.setattr(capacity, "available_gib", lambda: 0.1)
    with pytest.raises(
        SceneError,
        match=rf"GiB on {comm.size} of {comm.size} ranks, {os.uname().nodename} has 0.10 GiB",
    ):
        require_memory(comm, scene, surface_size(scene.surface), 1)
