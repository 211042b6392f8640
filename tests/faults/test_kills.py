"""kill -9 at any moment: what can be read is right, and the run goes on from where it was."""

import os
import random
import signal
import time

import pytest
from faults.jobs import EIGHT, Job, finish, needs_mpi, nothing_wrong, write_scene

from hpc_gfmd.output.read import partial_folder

RANKS = 2
MOMENTS = int(os.environ.get("HPC_GFMD_MOMENTS", "17"))  # of each target: about 50 in all
TARGETS = {"one rank": lambda job: job.ranks()[-1:], "all ranks": lambda job: job.ranks(), "mpirun": lambda job: []}


@pytest.fixture(scope="module")
def duration(tmp_path_factory):
    """Seconds of the run that is not killed, from the first file on."""
    path = write_scene(tmp_path_factory.mktemp("undisturbed"), loads=EIGHT)
    job = Job(["run", "scene.toml", "-q"], RANKS, path.parent)
    assert job.wait_for((partial_folder(path) / "head.h5").exists)
    begun = time.monotonic()
    assert job.end(60).code == 0, job.err
    return time.monotonic() - begun


def killed_and_continued(folder, target, wait, wanted, **how):
    """Kill; returns (exit code, seconds, steps finished before, whether a file was being written, message)."""
    path = write_scene(folder, **how)
    job = Job(["run", "scene.toml", "-q"], RANKS, folder)
    wait(job, path)
    writing = any(folder.rglob("*.tmp"))
    job.kill(signal.SIGKILL, *TARGETS[target](job))
    job.end()
    kept = nothing_wrong(path, wanted)
    finish(path, RANKS)
    nothing_wrong(path, wanted)
    return job.code, job.seconds, kept, writing


@needs_mpi
@pytest.mark.parametrize("target", ["one rank", *[pytest.param(name, marks=pytest.mark.slow) for name in ("all ranks", "mpirun")]])
def test_once(tmp_path, undisturbed, target, record):
    """In the middle of the sweep."""

    def wait(job, path):
        assert job.wait_for((partial_folder(path) / "step-0002.h5").exists), job.end().err

    code, seconds, kept, _ = killed_and_continued(tmp_path, target, wait, undisturbed(RANKS))
    assert code != 0
    assert kept >= 3
    record(f"kill -9 of {target}", "in the fourth of five loads, 2 ranks", code, "none: killed; restart is bit-identical", seconds)


@needs_mpi
@pytest.mark.slow
@pytest.mark.parametrize("target", TARGETS)
def test_at_random_moments(tmp_path, undisturbed, duration, target, record):
    """From the start to after the end, most of them while there are files."""
    dice, worst, counts = random.Random(f"{target} 1"), 0.0, {"complete": 0, "writing": 0, "not begun": 0}
    for moment in range(MOMENTS):
        folder = tmp_path / str(moment)
        folder.mkdir()
        early = moment % 5 == 0
        delay = dice.uniform(0.0, 2.0) if early else dice.uniform(0.0, 1.05 * duration)

        def wait(job, path, early=early, delay=delay):
            begun = early or job.wait_for((partial_folder(path) / "head.h5").exists)
            end = time.monotonic() + delay
            while begun and job.process.poll() is None and time.monotonic() < end:
                time.sleep(0.001)

        code, seconds, kept, writing = killed_and_continued(folder, target, wait, undisturbed(RANKS, loads=EIGHT), loads=EIGHT)
        worst = max(worst, seconds)
        counts["writing"] += writing
        counts["not begun"] += kept == 0
        counts["complete"] += code == 0
    assert counts["writing"] >= MOMENTS // 5
    record(f"kill -9 of {target} at {MOMENTS} random moments",
           f"8 loads, 2 ranks, a checkpoint in every iteration; {counts['writing']} times during a write, {counts['not begun']} times "
           f"before the first finished load, {counts['complete']} times after the end", "137 or 1, 0 after the end",
           "none: killed; every restart finishes, bit-identical", worst)
