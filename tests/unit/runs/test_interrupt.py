"""Requests to stop are heard between two iterations, too, and signal handlers come back; who
started this process can be said."""

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
from hpc_gfmd.surface import selfaffine

SCENE = {"surface": rough(), "load": {"p_star": [0.1, 0.3]}, "output": {"path": "out.h5"}}


def killing(function, n):
    """The same, with a SIGTERM to this process before it is called for a grid of n x n points (that
    of compiling has others)."""

    def call(what, *args, **kwargs):
        if getattr(what, "grid", what).n == (n, n):
            os.kill(os.getpid(), signal.SIGTERM)
        return function(what, *args, **kwargs)

    return call


@pytest.mark.parametrize(
    ("module", "name", "n"), [(selfaffine, "rms_of_columns", 64), (nested, "roughly_solved", 32)]
)
def test_stops_before_the_first_iteration(module, name, n, monkeypatch):
    """No iteration on the finest grid, the exit code of a signal, and a restart that ends as if
    nothing had happened."""
    before = signal.getsignal(signal.SIGTERM)
    with monkeypatch.context() as patched:
        patched.setattr(module, name, killing(getattr(module, name), n))
        run = run_scene(Scene.from_dict(SCENE), quiet=True)
    assert (run.status, run.exit_code, run.steps) == ("interrupted", 143, [])
    assert signal.getsignal(signal.SIGTERM) == before
    assert not Path("out.h5").exists()
    assert not Path("out.h5.partial/checkpoint.h5").exists()
    again = restart("out.h5", quiet=True)
    assert again.status == "converged"
    whole = run_scene(Scene.from_dict(SCENE), out="whole.h5", quiet=True)
    for found, wanted in zip(again.steps, whole.steps, strict=True):
        assert (found["a_r"], found["gap_mean"]) == (wanted["a_r"], wanted["gap_mean"])
    assert read_result("out.h5").status == "converged"


def test_only_the_run_itself_is_stopped():
    """What a rank does on its own, such as compiling, must not end on one rank alone."""
    comm = SerialComm()
    with Interrupt(comm) as interrupt:
        os.kill(os.getpid(), signal.SIGUSR1)
        check(SerialComm())
        with pytest.raises(Stopped):
            check(SerialComm(comm))
        assert interrupt.agreed == signal.SIGUSR1
    check(comm)


def test_time_that_is_up_stops_after_an_iteration():
    """So that a run gets on, however little time it has."""
    comm = SerialComm()
    with Interrupt(comm, deadline=-1.0) as interrupt:
        check(comm)
        assert interrupt.poll()
        assert interrupt.exit_code == 143


def test_handlers_come_back():
    def handler(number, frame):
        pass

    before = signal.signal(signal.SIGUSR1, handler)
    try:
        with Interrupt(SerialComm()) as interrupt:
            os.kill(os.getpid(), signal.SIGUSR1)
            assert interrupt.signal == signal.SIGUSR1
        assert signal.getsignal(signal.SIGUSR1) is handler
    finally:
        signal.signal(signal.SIGUSR1, before)
