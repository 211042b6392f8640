"""Signals: the gap is saved, the exit code is the documented one, and a restart gives the same
result."""

import signal
import time

import pytest
from faults.jobs import Job, assert_resumes, loads_in, needs_mpi, write_scene

SLOW = "slow -1 0.1"  # makes the run mostly write, and long enough for a signal
CODES = {"SIGTERM": 143, "SIGINT": 130, "SIGUSR1": 143}


def wait_for_third_load(job, path):
    assert job.wait_for(lambda: loads_in(path) >= 2), job.end().err


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
    wait_for_third_load(job, path)
    job.kill(getattr(signal, name), *(job.ranks()[-1:] if target == "one rank" else ()))
    job.end()
    assert "Traceback" not in job.err
    by_mpirun = target == "mpirun" and name != "SIGUSR1"
    # mpirun has its own exit code and kills its processes after a second, but passes SIGUSR1 on.
    if by_mpirun:
        assert job.code == 1
    else:
        assert job.code == CODES[name], (job.code, job.err)
        (line,) = (line for line in job.out.splitlines() if line.startswith("stopped"))
        assert f"{loads_in(path)} of 5 loads" in line
        assert f"hpc-gfmd restart {path.name}" in line
    assert_resumes(path, undisturbed(ranks), ranks, kept=2)


@needs_mpi
@pytest.mark.slow
def test_twice(undisturbed):
    """The second signal ends the run at once; finished loads are kept."""
    path = write_scene()
    job = Job("run scene.toml", 2, fault="slow -1 0.5")
    assert job.wait_for(lambda: loads_in(path) >= 1), job.end().err
    pids = job.ranks()[-1:]
    job.kill(signal.SIGUSR1, *pids)
    time.sleep(0.1)
    assert job.process.poll() is None
    job.kill(signal.SIGTERM, *pids)
    job.end()
    assert job.code != 0
    assert not path.exists()
    assert_resumes(path, undisturbed(2), 2)
