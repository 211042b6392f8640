"""Stopped by a signal or by its time limit, a run leaves what is finished and the gap of the load
that it was at, from which any number of ranks goes on."""

import pytest
from pieces import Pieces
from pieces import scene as small

from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.runs.simulation import restart
from hpc_gfmd.util.errors import SceneError

pytestmark = pytest.mark.mpi


# tests/unit/runs/test_restart.py has all solvers, on one process
@pytest.mark.parametrize(
    ("solver", "boundary", "loads"),
    [
        ("bpx", "periodic", [0.1, 0.11, 0.12]),
        ("gfmd", "periodic", [0.1, 0.11, 0.12]),
        ("bpx", "free", {"approach": [0.1, 0.02, 0.03]}),
    ],
)
def test_as_many_ranks(comm, shared_path, monkeypatch, solver, boundary, loads):
    """Stopped in the first load and at the end of the second, then dead without a word."""
    pieces = Pieces(monkeypatch, comm, shared_path)
    asked = small(solver, loads, boundary=boundary, accuracy=1e-5)
    part = pieces.undisturbed(asked) // 3
    pieces.run(asked, (part // 2, False), (part + part // 2, False), (part // 2, True))
    pieces.compare(rel=2e-5)


@pytest.mark.parametrize("boundary", ["periodic", "free"])
def test_another_number_of_ranks(comm, shared_path, monkeypatch, boundary):
    """Begun by all ranks, continued by one, and then by all again, and the other way round."""
    pieces = Pieces(monkeypatch, comm, shared_path)
    alone = SerialComm()
    asked = small("auto", [0.02, 0.025, 0.2], accuracy=None, residual=1e-11, boundary=boundary)
    part = pieces.undisturbed(asked) // 3
    pieces.run(asked, comms=(alone,))
    pieces.compare(rel=1e-10)
    for comms in ((comm, alone, comm), (alone, comm, alone)):
        pieces.run(asked, (part, False), (part, False), comms=comms)
        pieces.compare(rel=1e-8)


def test_restart_of_what_is_not_there(comm):
    with pytest.raises(SceneError, match="no interrupted run"):
        restart("nothing.h5", comm=comm)
