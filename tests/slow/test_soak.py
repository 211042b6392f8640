"""Two hundred loads: memory, descriptors and files do not grow."""

import json
import os
import time

import numpy as np
import pytest
from contacts import scene_text
from faults.jobs import Job, run

from hpc_gfmd.output.read import read_result
from hpc_gfmd.util.errors import GfmdError

STEPS = 200
N = 256
SCENE = scene_text(
    (2, N // 4, 2),
    np.geomspace(0.005, 1.0, STEPS).round(6).tolist(),
    solver={"name": "gfmd", "accuracy": 1e-7, "precision": "double"},
    output={"path": "soak.h5", "fields": ["gap"]},
)
WARM = 0.25  # share of the run after which the memory must not grow
BYTES_OF_NUMBERS = 20_000  # of a load beside its fields: measured 16,000, mostly HDF5's own
GROWTH_MB = 8.0  # allowed growth of the memory of a rank; a field has 0.5 MB


def sample(pid):
    """Return (resident MB, open descriptors) of a process, None if it has ended."""
    try:
        with open(f"/proc/{pid}/status") as file:
            kib = next(int(line.split()[1]) for line in file if line.startswith("VmRSS"))
        return kib / 1024, len(os.listdir(f"/proc/{pid}/fd"))
    except (OSError, StopIteration):
        return None


def watch(job, folder):
    """Sample all ranks until the run ends; return {pid: [(MB, descriptors, finished loads)]}."""
    samples = {}
    while job.process.poll() is None:
        time.sleep(0.1)
        finished = finished_loads(folder / "soak.h5")
        for pid in job.ranks():
            if taken := sample(pid):
                samples.setdefault(pid, []).append((*taken, finished))
    return samples


def finished_loads(path):
    """Return how many loads of a run, which may not have begun, can be read."""
    try:
        return len(read_result(path).steps)
    except (GfmdError, OSError):
        return 0


@pytest.mark.slow
@pytest.mark.alone
@pytest.mark.parametrize("ranks", [None, 2])
def test_soak(ranks, tmp_path, monkeypatch):
    (tmp_path / "soak.toml").write_text(SCENE)
    (tmp_path / "tmp").mkdir()
    monkeypatch.setenv("TMPDIR", str(tmp_path / "tmp"))
    plan = run("plan soak.toml --json", cwd=tmp_path)
    job = Job("run soak.toml -q", ranks, tmp_path)
    samples = watch(job, tmp_path)
    assert job.end(3600).code == 0, job.err
    # A child process of a rank appears at most once.
    series_of_ranks = [series for series in samples.values() if len(series) > 1]
    assert len(series_of_ranks) == (ranks or 1)

    result = read_result(tmp_path / "soak.h5")
    assert [step["status"] for step in result.steps] == ["converged"] * STEPS
    predicted = json.loads(plan.out)["file_gib"] * 2**30
    assert predicted == STEPS * N * N * 8
    size = (tmp_path / "soak.h5").stat().st_size
    assert 0 <= size - predicted < BYTES_OF_NUMBERS * STEPS
    assert sorted(p.name for p in tmp_path.iterdir()) == ["soak.h5", "soak.toml", "tmp"]
    left = [p for p in (tmp_path / "tmp").rglob("*") if p.is_file()]
    assert left == []

    for series in series_of_ranks:
        warm = [taken for taken in series if WARM * STEPS <= taken[2] < STEPS]
        assert len(warm) > 20
        resident = [taken[0] for taken in warm]
        descriptors = [taken[1] for taken in warm]
        third = len(warm) // 3
        assert np.median(resident[-third:]) - np.median(resident[:third]) < GROWTH_MB
        assert max(descriptors) - min(descriptors) <= 4  # the file being written
        assert descriptors[-1] <= min(descriptors) + 4
