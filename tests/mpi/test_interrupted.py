"""Stopped by a signal or by its time limit, a run leaves a checkpoint from which any number of
ranks goes on."""

import os
import signal
import subprocess
import time

import numpy as np
import pytest
from contacts import EXACT, rough, scene_text
from mpi_harness import end
from pieces import Pieces
from pieces import scene as small

from hpc_gfmd.output.folder import is_held, partial_folder
from hpc_gfmd.output.read import read_result
from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.parallel.interrupt import Interrupt
from hpc_gfmd.runs.simulation import restart, run_scene
from hpc_gfmd.scene import Scene
from hpc_gfmd.util.errors import SceneError

pytestmark = pytest.mark.mpi


def scene(**machine):
    return Scene.from_dict(
        {
            "surface": rough((2, 16, 2)),
            "load": {"p_star": [0.02, 0.2]},
            "solver": EXACT,
            "output": {"fields": ["gap"]},
            "machine": machine,
        }
    )


def test_time_limit_and_restart(comm, shared_path, monkeypatch):
    """Stopped in every iteration, one process and all ranks in turns, it ends with the answer of an
    uninterrupted run."""
    whole = run_scene(scene(), out=shared_path / "whole.h5", quiet=True, comm=comm)
    path = shared_path / "pieces.h5"
    with pytest.raises(SceneError, match="wall_seconds: found 1e-09, allowed: more than the"):
        run_scene(scene(wall_seconds=1e-9), out=path, quiet=True, comm=comm)
    assert comm.rank or not partial_folder(path).exists()
    monkeypatch.setattr(Interrupt, "require_time", lambda self: None)
    run = run_scene(scene(wall_seconds=1e-9), out=path, quiet=True, comm=comm)
    assert (run.status, run.exit_code) == ("interrupted", 143)
    assert not path.exists()
    assert (partial_folder(path) / "checkpoint.h5").exists()
    comm.barrier()  # until rank 0 has let go of the lock it is "running"
    assert read_result(path).status == "interrupted"
    comm.barrier()
    again = run_scene(scene(wall_seconds=1e-9), out=path, quiet=True, comm=comm)
    assert again.status == "interrupted"
    run = run_scene(scene(), out=path, quiet=True, comm=comm)
    assert run.exit_code == 0
    for found, wanted in zip(run.steps, whole.steps, strict=True):
        for name in ("a_r", "gap_mean", "energy", "kappa"):
            assert found[name] == pytest.approx(wanted[name], rel=1e-10), name
    found, wanted = (
        read_result(p).fields[1]["gap"].read(0, 64) for p in (path, shared_path / "whole.h5")
    )
    assert np.abs(found - wanted).max() < 1e-10 * wanted.max()
    assert not partial_folder(path).exists()


# tests/unit/run/test_restart.py has all solvers, on one process
@pytest.mark.parametrize(
    ("solver", "boundary", "loads"),
    [
        ("bpx", "periodic", [0.1, 0.11, 0.12]),
        ("ccg", "periodic", [0.1, 0.11, 0.12]),
        ("bpx", "free", {"approach": [0.1, 0.02, 0.03]}),
    ],
    ids=str,
)
def test_bit_identical(comm, shared_path, monkeypatch, solver, boundary, loads):
    """On as many ranks: stopped in the first load and at the end of the second, then dead without a
    word."""
    pieces = Pieces(monkeypatch, comm, shared_path)
    asked = small(solver, loads, boundary=boundary)
    part = pieces.undisturbed(asked) // 3
    pieces.run(asked, (part // 2, False, ()), (part + part // 2, False, ()), (part // 2, True, ()))
    pieces.compare()


def test_another_number_of_ranks(comm, shared_path, monkeypatch):
    """Begun by all ranks, continued by one, and then by all again, and the other way round: equal
    within rounding."""
    pieces, alone = Pieces(monkeypatch, comm, shared_path), SerialComm()
    asked = small("auto", [0.02, 0.025, 0.2], accuracy=None, residual=1e-11)
    part = pieces.undisturbed(asked) // 3
    for comms in ((comm, alone, comm), (alone, comm, alone)):
        pieces.run(asked, (part, False, ()), (part, False, ()), comms=comms)
        pieces.compare(rel=1e-10)


def test_restart_of_what_is_not_there(comm, shared_path):
    with pytest.raises(SceneError, match="no interrupted run"):
        restart(shared_path / "nothing.h5", comm=comm)


SLOW = scene_text(
    (2, 128, 2),
    [0.01 * 1.3 ** (i % 9) for i in range(300)],
    output={"path": "slow.h5"},
    solver={"residual": 1e-14, "precision": "double", "max_iterations": 10**7},
)


def test_signal(mpirun, tmp_path):
    """A signal to the job in one of its many load steps leaves what can be continued, and no
    result."""
    (tmp_path / "scene.toml").write_text(SLOW)
    process = mpirun.start(["-m", "hpc_gfmd", "run", "scene.toml"], subprocess.PIPE, cwd=tmp_path)
    try:
        head, since = tmp_path / "slow.h5.partial" / "head.h5", time.monotonic()
        while not (head.exists() and b"setup_seconds" in head.read_bytes()):
            assert process.poll() is None, process.communicate()
            assert time.monotonic() - since < 60
            time.sleep(0.02)
        time.sleep(0.3)
        os.kill(process.pid, signal.SIGTERM)  # mpirun passes it on
        _, err = process.communicate(timeout=60)
    finally:
        end(process)
    assert process.returncode != 0
    assert b"Traceback" not in err
    assert not (tmp_path / "slow.h5").exists()
    while is_held(head.parent) and time.monotonic() - since < 120:
        time.sleep(0.02)  # mpirun does not wait for ranks that it has killed
    assert read_result(tmp_path / "slow.h5").status == "interrupted"
    assert [p for p in head.parent.iterdir() if p.name.startswith(("checkpoint", "step"))], err
