"""A run stopped by a signal or its time limit resumes on any number of ranks.

It keeps its finished loads and the gap of the unfinished one.
"""

import pytest
from pieces import Pieces
from pieces import scene as small

from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.runs.simulation import restart
from hpc_gfmd.util.errors import SceneError

pytestmark = [pytest.mark.mpi, pytest.mark.two_ranks]


# All solvers are in tests/unit/runs/test_restart.py, on one process.
@pytest.mark.parametrize(
    ("solver", "boundary", "loads"),
    [
        ("bpx", "periodic", [0.1, 0.11, 0.12]),
        ("gfmd", "periodic", [0.1, 0.11, 0.12]),
        ("bpx", "free", {"approach": [0.1, 0.02, 0.03]}),
    ],
)
def test_the_same_number_of_ranks(comm, shared_path, monkeypatch, solver, boundary, loads):
    """Stopped in the first load and near the end of the second, then killed."""
    pieces = Pieces(monkeypatch, comm, shared_path)
    scene = small(solver, loads, boundary=boundary, accuracy=1e-6)
    part = pieces.undisturbed(scene) // 3
    pieces.run(scene, (part // 2, False), (part + part // 2, False), (part // 2, True))
    pieces.compare(rel=2e-5)


@pytest.mark.parametrize("boundary", ["periodic", pytest.param("free", marks=pytest.mark.quick)])
def test_another_number_of_ranks(comm, shared_path, monkeypatch, boundary):
    """Started on all ranks, resumed on one and then on all again, and vice versa."""
    pieces = Pieces(monkeypatch, comm, shared_path)
    alone = SerialComm()
    scene = small("auto", [0.02, 0.025, 0.2], accuracy=None, residual=1e-11, boundary=boundary)
    part = pieces.undisturbed(scene) // 3
    pieces.run(scene, comms=(alone,))
    pieces.compare(rel=1e-10)
    for comms in ((comm, alone, comm), (alone, comm, alone)):
        pieces.run(scene, (part, False), (part, False), comms=comms)
        pieces.compare(rel=1e-8)


@pytest.mark.parametrize("boundary", [pytest.param("periodic", marks=pytest.mark.quick), "free"])
def test_a_history_on_another_number_of_ranks(comm, shared_path, monkeypatch, boundary):
    """Its memory is taken up by one rank and by all, after a stop and after a kill."""
    pieces = Pieces(monkeypatch, comm, shared_path)
    alone = SerialComm()
    loads = {"p_star": [0.2, 0.05, 0.0, 0.25], "history": True}
    exact = {"accuracy": None, "residual": 1e-11, "material": {"hardness": 0.8}}
    scene = small("auto", loads, ("dent", "gap"), boundary, **exact)
    part = pieces.undisturbed(scene) // 3
    pieces.run(scene, (part, False), (part, True), comms=(comm, alone, comm))
    pieces.compare(rel=1e-8)


def test_restart_without_a_run(comm):
    with pytest.raises(SceneError, match="no interrupted run"):
        restart("nothing.h5", comm=comm)
