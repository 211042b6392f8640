"""Faults on one rank: all ranks end, one line names the reason, and no wrong result is left."""

import json
from pathlib import Path

import pytest
from faults.jobs import Job, assert_resumes, assert_sound, call, needs_mpi, run, write_scene

from hpc_gfmd.output.folder import partial_folder
from hpc_gfmd.output.read import read_result

pytestmark = needs_mpi
RANKS = 2
INTERNAL = "internal error on rank 1: RuntimeError: sabotage"
EXCEPTIONS = {  # where: (fault, number of ranks, message)
    "while the surface is made": ("surface 1", RANKS, INTERNAL),
    "in the middle of a solve": ("solve 1 20", RANKS, INTERNAL),
    "in the writer": ("write 1 3", RANKS, r"writing .*\.h5: sabotage"),
    "in the writer, rank 0": ("write 0 3", RANKS, r"writing .*\.h5: sabotage"),
    "where memory is allocated": ("no_memory 1 20", RANKS, "out of memory"),
    "where memory is allocated, alone": ("no_memory 0 20", None, "out of memory"),
}


@pytest.mark.parametrize(
    "where",
    [
        pytest.param(name, marks=[] if name == "in the middle of a solve" else pytest.mark.slow)
        for name in EXCEPTIONS
    ],
)
def test_exception(undisturbed, where):
    fault, ranks, message = EXCEPTIONS[where]
    path = write_scene()
    job = run("run scene.toml", ranks, fault=fault)
    assert job.code == 1, (job.code, job.err)
    job.says(message)
    assert not path.exists()
    assert_resumes(path, undisturbed(ranks), ranks)


@pytest.mark.slow
@pytest.mark.parametrize(("value", "precision"), [("nan", "double"), ("-inf", "single")])
def test_not_a_number(value, precision):
    """A nan on one rank in the middle of the second load: only that load is nonfinite."""
    path = write_scene(loads=[0.02, 0.024, 0.2, 0.24], residual=1e-4)
    words = f"run scene.toml --set solver.precision={precision}"
    job = run(words, RANKS, fault=f"nan 1 12 {value}")
    assert job.code == 3, job.err
    result = read_result(path)
    status = [step["status"] for step in result.steps]
    assert result.status == "nonfinite"
    assert status.count("nonfinite") == 1
    assert status.count("converged") == 3
    shown = json.loads(call("show out.h5 --json").out)
    assert shown["status"] == "nonfinite"
    assert "NOT CONVERGED (nonfinite)" in call("show out.h5").out


@pytest.mark.slow
def test_memory_limit_at_start():
    """ulimit -v is checked before anything is computed."""
    path = write_scene(lam=2048, loads=[0.1])
    wrapped = ["bash", "-c", 'ulimit -v 3000000; exec "$@"', "-"]
    job = run("run scene.toml", wrapped=wrapped)
    assert job.code == 2, (job.code, job.err)
    job.says("need .* GiB")
    assert not path.exists()
    assert not partial_folder(path).exists()


@pytest.mark.slow
def test_two_runs(undisturbed):
    """A second run is refused and does not disturb the first one."""
    path = write_scene()
    flag = Path("held")
    running = Job("run scene.toml", RANKS, fault=f"hold 0 committed sync committed.tmp {flag}")
    assert running.wait_for(flag.exists)
    for job in (run("run scene.toml", RANKS), run("restart out.h5")):
        assert job.code == 2, job.err
        job.says("another run is writing this file")
    flag.unlink()
    assert running.end(60).code == 0
    assert_sound(path, undisturbed(RANKS))
