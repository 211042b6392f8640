"""kill -9 at any moment: what can be read is right, and the run can be resumed."""

import random
import signal
import time
from functools import partial
from pathlib import Path

import pytest
from faults.jobs import Job, assert_resumes, needs_mpi, write_scene

from hpc_gfmd.output.folder import has_begun, partial_folder
from hpc_gfmd.output.record import MEMORY, STATES

pytestmark = needs_mpi
RANKS = 2
MOMENTS = 20
TARGETS = {
    "one rank": lambda job: job.ranks()[-1:],
    "all ranks": lambda job: job.ranks(),
    "mpirun": lambda job: [],
}
# {where: (rank that is blocked, module of parallel/ and its function, text in its arguments)}
HELD = {
    "in a write of rows": (1, "h5 _piece", "LazyField"),
    "before a commit": (0, "committed sync", "committed.tmp"),
}


@pytest.mark.parametrize(
    ("where", "target"),
    [
        pytest.param(
            where,
            target,
            marks=[] if (where, target) == ("in a write of rows", "one rank") else pytest.mark.slow,
        )
        for where in HELD
        for target in TARGETS
    ],
)
def test_held(undisturbed, where, target):
    """Processes are killed while a rank is blocked."""
    rank, function, text = HELD[where]
    path = write_scene()
    job = Job("run scene.toml -q", RANKS, fault=f"hold {rank} {function} {text} held")
    assert job.wait_for(Path("held").exists), job.end().err
    job.kill(signal.SIGKILL, *TARGETS[target](job))
    job.end()
    assert job.code != 0
    Path("held").unlink()
    assert_resumes(path, undisturbed(RANKS), RANKS)


@pytest.mark.slow
@pytest.mark.parametrize("ranks", [(None, RANKS), (RANKS, None)])
def test_a_history(tmp_path, undisturbed, ranks):
    """Killed at its begin, and soon after each load has left its dents; resumed on another number
    of ranks."""
    settings = {"loads": [0.05, 0.3, 0.1, 0.02, 0.25], "hardness": 0.6}
    dice = random.Random(2)
    for moment in range(6):
        folder = tmp_path / str(moment)
        folder.mkdir()
        path = write_scene(folder, **settings)
        left = partial_folder(path) / STATES[MEMORY].format(moment - 1)
        happened = left.exists if moment else partial(has_begun, partial_folder(path))
        job = Job("run scene.toml -q", ranks[0], folder)
        if job.wait_for(happened):
            time.sleep(dice.choice((0.0, 0.0, 0.02)))
        job.kill(signal.SIGKILL, *job.ranks())
        job.end()
        assert_resumes(path, undisturbed(ranks[0], **settings), ranks[1])


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
        begun = job.wait_for(partial(has_begun, partial_folder(path)))
        end = time.monotonic() + dice.uniform(0.0, 1.05 * duration)
        while begun and job.process.poll() is None and time.monotonic() < end:
            time.sleep(0.001)
        target = list(TARGETS)[moment % 3]
        job.kill(signal.SIGKILL, *TARGETS[target](job))
        job.end()
        assert_resumes(path, undisturbed(RANKS), RANKS)
