"""Signals and wall time stop a run before the first and between iterations; signal handlers are
restored."""

import os
import signal
from pathlib import Path

import pytest
from contacts import rough

from hpc_gfmd.driver import nested
from hpc_gfmd.output.read import read_result
from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.parallel.interrupt import Interrupt, Stopped, check
from hpc_gfmd.runs.simulation import restart, run_scene
from hpc_gfmd.scene import Scene
from hpc_gfmd.surface import modes

SCENE = {"surface": rough(), "load": {"p_star": [0.1, 0.3]}, "output": {"path": "out.h5"}}


def killing(function, n):
    """Wrap a function: before calls with a grid of n x n points, this process gets SIGTERM."""

    def call(argument, *args, **kwargs):
        if getattr(argument, "grid", argument).n == (n, n):
            os.kill(os.getpid(), signal.SIGTERM)
        return function(argument, *args, **kwargs)

    return call


@pytest.mark.parametrize(
    ("module", "name", "n"), [(modes, "roughness_of_columns", 64), (nested, "roughly_solved", 32)]
)
def test_run_stops_before_the_first_iteration(module, name, n, monkeypatch):
    """No iteration on the finest grid; the restart gives the uninterrupted result."""
    before = signal.getsignal(signal.SIGTERM)
    with monkeypatch.context() as patched:
        patched.setattr(module, name, killing(getattr(module, name), n))
        run = run_scene(Scene.from_dict(SCENE), quiet=True)
    assert (run.status, run.exit_code, run.steps) == ("interrupted", 143, [])
    assert signal.getsignal(signal.SIGTERM) == before
    assert not Path("out.h5").exists()
    assert not Path("out.h5.partial/checkpoint.h5").exists()
    resumed = restart("out.h5", quiet=True)
    assert resumed.status == "converged"
    whole = run_scene(Scene.from_dict(SCENE), out="whole.h5", quiet=True)
    for name in ("a_r", "gap_mean"):
        assert [step[name] for step in resumed.steps] == [step[name] for step in whole.steps]
    assert read_result("out.h5").status == "converged"


def test_only_the_communicator_of_the_run_is_stopped():
    """Work of single ranks, such as compilation, must not stop on one rank alone."""
    comm = SerialComm()
    with Interrupt(comm):
        os.kill(os.getpid(), signal.SIGUSR1)
        check(SerialComm())
        with pytest.raises(Stopped) as stopped:
            check(SerialComm(comm))
        assert stopped.value.number == signal.SIGUSR1
    check(comm)


def test_deadline_stops_after_an_iteration():
    """Runs make progress in any wall time."""
    comm = SerialComm()
    with Interrupt(comm, deadline=-1.0) as interrupt:
        check(comm)
        assert Stopped(interrupt.poll()).exit_code == 143
