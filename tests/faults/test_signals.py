"""Signals: the gap is kept, the documented exit code, and a restart that ends as if nothing had
happened."""

import signal
import time
from pathlib import Path

import pytest
from faults.jobs import Job, goes_on, needs_mpi, write_scene

from hpc_gfmd.output.folder import partial_folder

SLOW = "slow -1 0.1"  # a run is mostly writing then, and long enough to be hit
CODES = {"SIGTERM": 143, "SIGINT": 130, "SIGUSR1": 143}


def third_load(job, path):
    assert job.wait_for((partial_folder(path) / "step-0001.h5").exists), job.end().err


@pytest.mark.parametrize(
    ("name", "ranks", "target"),
    [
        ("SIGTERM", None, "the program"),
        pytest.param("SIGINT", None, "the program", marks=pytest.mark.slow),
        *[
            pytest.param(*case, marks=[needs_mpi, pytest.mark.slow])
            for case in (
                ("SIGTERM", 2, "mpirun"),
                ("SIGUSR1", 2, "mpirun"),
                ("SIGUSR1", 2, "one rank"),
            )
        ],
    ],
)
def test_signal(undisturbed, name, ranks, target):
    path = write_scene()
    job = Job("run scene.toml", ranks, fault=SLOW)
    third_load(job, path)
    job.kill(getattr(signal, name), *(job.ranks()[-1:] if target == "one rank" else ()))
    job.end()
    assert "Traceback" not in job.err
    by_mpirun = target == "mpirun" and name != "SIGUSR1"
    # it has its own code, and kills after a second those that are not ready; SIGUSR1 it passes on
    if by_mpirun:
        assert job.code == 1
    else:
        assert job.code == CODES[name], (job.code, job.err)
        (line,) = (line for line in job.out.splitlines() if line.startswith("stopped"))
        assert "2 of 5 loads" in line
        assert f"hpc-gfmd restart {path.name}" in line
    goes_on(path, undisturbed(ranks), ranks, kept=2)


@needs_mpi
@pytest.mark.slow
def test_twice(undisturbed):
    """The second signal ends the run at once: what was finished is there."""
    path = write_scene()
    job = Job("run scene.toml", 2, fault="slow -1 0.5")
    assert job.wait_for((partial_folder(path) / "step-0000.h5.tmp").exists), job.end().err
    pids = job.ranks()[-1:]
    job.kill(signal.SIGUSR1, *pids)
    time.sleep(0.1)
    assert job.process.poll() is None
    job.kill(signal.SIGTERM, *pids)
    job.end()
    assert job.code != 0
    assert not path.exists()
    goes_on(path, undisturbed(2), 2)


@needs_mpi
def test_one_rank_at_start():
    """Before it has begun nothing has to be kept, but no rank may wait for the one that is gone."""
    path = write_scene()
    job = Job("run scene.toml", 2, fault="lag -1 30 begun")
    assert job.wait_for(lambda: any(Path().glob("begun-*"))), job.end().err
    flag = next(Path().glob("begun-*"))
    job.kill(signal.SIGINT, int(flag.name.removeprefix("begun-")))
    job.end()
    assert job.code != 0
    assert not path.exists()
