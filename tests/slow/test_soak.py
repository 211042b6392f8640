"""Two hundred load steps: memory, descriptors and files stay what they are."""

import json
import os
import time

import numpy as np
import pytest
from contacts import scene_text
from faults.jobs import Job, run

from hpc_gfmd.output.read import read_result

STEPS, N = 200, 256
SCENE = scene_text(
    (2, N // 4, 2),
    np.geomspace(0.005, 1.0, STEPS).round(6).tolist(),
    solver={"name": "gfmd", "accuracy": 1e-7, "precision": "double"},
    output={"path": "soak.h5", "fields": ["gap"]},
)
WARM = 0.25  # of the run, before which nothing is compared
GROWTH_MB = 8.0  # of the memory of a rank afterwards; a field has 0.5 MB


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


def watch(job, folder):
    """Sample all ranks until the run ends: {pid: [(resident, descriptors, finished steps)]}."""
    samples = {}
    while job.process.poll() is None:
        time.sleep(0.1)
        partial = folder / "soak.h5.partial"
        done = len(list(partial.glob("step-*.h5"))) if partial.is_dir() else 0
        for pid in job.ranks():
            if found := sample(pid):
                samples.setdefault(pid, []).append((*found, done))
    return samples


@pytest.mark.slow
@pytest.mark.parametrize("ranks", [None, 2])
def test_soak(ranks, tmp_path, monkeypatch):
    (tmp_path / "soak.toml").write_text(SCENE)
    (tmp_path / "tmp").mkdir()
    monkeypatch.setenv("TMPDIR", str(tmp_path / "tmp"))
    plan = run("plan soak.toml --json", cwd=tmp_path)
    job = Job("run soak.toml -q", ranks, tmp_path)
    samples = watch(job, tmp_path)
    assert job.end(3600).code == 0, job.err
    samples = {
        pid: own for pid, own in samples.items() if len(own) > 1
    }  # what a rank starts is seen once, if at all
    assert len(samples) == (ranks or 1)

    result = read_result(tmp_path / "soak.h5")
    assert [step["status"] for step in result.steps] == ["converged"] * STEPS
    predicted = json.loads(plan.out)["file_gib"] * 2**30
    assert predicted == STEPS * N * N * 8
    size = (tmp_path / "soak.h5").stat().st_size
    assert 1.0 <= size / predicted < 1.02
    assert sorted(p.name for p in tmp_path.iterdir()) == ["soak.h5", "soak.toml", "tmp"]
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
