"""kill -9 at any moment: what can be read is right, and the run can be resumed."""

import random
import signal
import time
from pathlib import Path

import pytest
from faults.jobs import Job, assert_resumes, needs_mpi, write_scene

from hpc_gfmd.output.folder import partial_folder

pytestmark = needs_mpi
RANKS = 2
MOMENTS = 9
TARGETS = {
    "one rank": lambda job: job.ranks()[-1:],
    "all ranks": lambda job: job.ranks(),
    "mpirun": lambda job: [],
}
# {where: (rank that is blocked, function of parallel/h5.py, file, finished loads)}; the other ranks
# continue as far as they can
HELD = {
    "in a collective write": (1, "_write", "step-0002.h5", 2),
    "before a file gets its name": (0, "sync", "step-0002.h5.tmp", 2),
    "in the collective write of the result": (1, "_write", "out.h5.tmp", 5),
}


@pytest.mark.parametrize(
    ("where", "target"),
    [
        pytest.param(
            where,
            target,
            marks=[]
            if (where, target) == ("in a collective write", "one rank")
            else pytest.mark.slow,
        )
        for where in HELD
        for target in TARGETS
    ],
)
def test_held(undisturbed, where, target):
    """Processes are killed while a rank is blocked."""
    rank, function, file, kept = HELD[where]
    path = write_scene()
    job = Job("run scene.toml -q", RANKS, fault=f"hold {rank} {function} {file} held")
    assert job.wait_for(Path("held").exists), job.end().err
    job.kill(signal.SIGKILL, *TARGETS[target](job))
    job.end()
    assert job.code != 0
    assert any(path.parent.rglob("*.tmp"))
    Path("held").unlink()
    assert_resumes(path, undisturbed(RANKS), RANKS, kept)


@pytest.mark.slow
def test_at_random_moments(tmp_path, undisturbed):
    """Between the start and a moment after the end."""
    dice = random.Random(1)
    duration = 2.0
    for moment in range(MOMENTS):
        folder = tmp_path / str(moment)
        folder.mkdir()
        path = write_scene(folder)
        job = Job("run scene.toml -q", RANKS, folder)
        begun = job.wait_for((partial_folder(path) / "head.h5").exists)
        end = time.monotonic() + dice.uniform(0.0, 1.05 * duration)
        while begun and job.process.poll() is None and time.monotonic() < end:
            time.sleep(0.001)
        target = list(TARGETS)[moment % 3]
        job.kill(signal.SIGKILL, *TARGETS[target](job))
        job.end()
        assert_resumes(path, undisturbed(RANKS), RANKS)
