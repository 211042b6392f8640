"""Two hundred load steps with a checkpoint every second: memory, descriptors and files stay what
they are."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from contacts import scene_text
from faults.jobs import command_of
from mpi_harness import end, environment

from hpc_gfmd.output.read import read_result

STEPS, N = 200, 256
SCENE = scene_text(
    (2, N // 4, 2),
    np.geomspace(0.005, 1.0, STEPS).round(6).tolist(),
    machine={"checkpoint_seconds": 1},
    solver={"name": "gfmd", "accuracy": 1e-7, "precision": "double"},
    output={"path": "soak.h5", "fields": ["gap"]},
)
WARM = 0.25  # of the run, before which nothing is compared
GROWTH_MB = 8.0  # of the memory of a rank afterwards; a field has 0.5 MB


def descendants(pid):
    """All processes that `pid` has started, and theirs."""
    try:
        children = [
            int(c)
            for task in Path(f"/proc/{pid}/task").iterdir()
            for c in (task / "children").read_text().split()
        ]
    except OSError:
        return []
    return children + [d for child in children for d in descendants(child)]


def sample(pid):
    """(resident MB, open descriptors) of a process; None once it is gone."""
    try:
        with open(f"/proc/{pid}/status") as file:
            resident = (
                next(int(line.split()[1]) for line in file if line.startswith("VmRSS")) / 1024
            )
        return resident, len(os.listdir(f"/proc/{pid}/fd"))
    except (OSError, StopIteration):
        return None


def watch(process, folder, ranks):
    """Sample all ranks until the run ends: {pid: [(resident, descriptors, finished steps), ...]},
    and how many checkpoints it saw."""
    samples, checkpoints, last = {}, 0, None
    while process.poll() is None:
        time.sleep(0.1)
        partial = folder / "soak.h5.partial"
        done = len(list(partial.glob("step-*.h5"))) if partial.is_dir() else 0
        pids = [process.pid] if ranks == 1 else descendants(process.pid)
        for pid in pids:
            found = sample(pid)
            if (
                found
                and b"hpc_gfmd" in command_of(pid)
                and b"mpirun" not in command_of(pid).split(b"\0")[0]
            ):
                samples.setdefault(pid, []).append((*found, done))
        try:
            stamp = (partial / "checkpoint.h5").stat().st_mtime_ns
        except OSError:
            continue
        checkpoints, last = checkpoints + (stamp != last), stamp
    return samples, checkpoints


@pytest.mark.slow
@pytest.mark.parametrize("ranks", [1, 2])
def test_soak(ranks, tmp_path):
    (tmp_path / "soak.toml").write_text(SCENE)
    env = environment(TMPDIR=str(tmp_path / "tmp"))
    (tmp_path / "tmp").mkdir()
    plan = subprocess.run(
        [sys.executable, "-m", "hpc_gfmd", "plan", "soak.toml", "--json"],
        cwd=tmp_path,
        env=env,
        capture_output=True,
        check=True,
    )
    command = [sys.executable, "-m", "hpc_gfmd", "run", "soak.toml"]
    with open(tmp_path / "log", "w") as log:
        process = subprocess.Popen(
            command if ranks == 1 else ["mpirun", "-n", str(ranks), *command],
            cwd=tmp_path,
            env=env,
            stdout=log,
            stderr=log,
            start_new_session=True,
        )
        try:
            samples, checkpoints = watch(process, tmp_path, ranks)
        finally:
            end(process)
    assert process.returncode == 0, (tmp_path / "log").read_text()[-2000:]
    samples = {
        pid: own for pid, own in samples.items() if len(own) > 1
    }  # what a rank starts is seen once, if at all
    assert len(samples) == ranks

    result = read_result(tmp_path / "soak.h5")
    assert [step["status"] for step in result.steps] == ["converged"] * STEPS
    predicted = json.loads(plan.stdout)["file_gib"] * 2**30
    assert predicted == STEPS * N * N * 8
    size = (tmp_path / "soak.h5").stat().st_size
    assert 1.0 <= size / predicted < 1.02
    assert sorted(p.name for p in tmp_path.iterdir()) == ["log", "soak.h5", "soak.toml", "tmp"]
    left = [p for p in (tmp_path / "tmp").rglob("*") if p.is_file()]
    assert left == []

    for own in samples.values():
        warm = [s for s in own if WARM * STEPS <= s[2] < STEPS]
        assert len(warm) > 20
        resident, descriptors = [s[0] for s in warm], [s[1] for s in warm]
        third = len(warm) // 3
        assert np.median(resident[-third:]) - np.median(resident[:third]) < GROWTH_MB
        assert max(descriptors) - min(descriptors) <= 4  # the file being written
        assert descriptors[-1] <= min(descriptors) + 4
    assert checkpoints > 5
