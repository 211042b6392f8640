"""Set-up and results on a machine with Debian's MPICH alone, which the wheel of mpi4py does not
support."""

import os
import shutil
import subprocess
from pathlib import Path

import h5py
import numpy as np
import pytest
from contacts import scene_text

ROOT = Path(__file__).parents[2]
ALONE = Path(__file__).with_name("mpich_alone.sh")
PROGRAMS = "mpicc.mpich", "mpirun.mpich", "h5pcc.mpich"
MISSING = [name for name in PROGRAMS if not shutil.which(name)]
FIELDS = "gap", "pressure"

pytestmark = [
    pytest.mark.slow,
    pytest.mark.alone,
    pytest.mark.skipif(os.getuid() != 0, reason="only root can hide the other MPI"),
    pytest.mark.skipif(
        bool(MISSING),
        reason="needs Debian's mpich, libmpich-dev, libhdf5-mpich-dev beside Open MPI",
    ),
]


@pytest.fixture(scope="module")
def clone(tmp_path_factory):
    """A clone in which scripts/setup has run with MPICH alone, which compiles for some minutes."""
    folder = tmp_path_factory.mktemp("mpich")
    listed = subprocess.check_output(["git", "ls-files", "-z"], cwd=ROOT).split(b"\0")[:-1]
    for name in map(os.fsdecode, listed):
        (folder / "clone" / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / name, folder / "clone" / name)
    process = subprocess.run(
        [ALONE, folder / "clone" / "scripts" / "setup"],
        env=os.environ | {"XDG_CACHE_HOME": str(folder / "cache")},
        capture_output=True,
        text=True,
    )
    assert process.returncode == 0, process.stderr
    assert "compiling mpi4py" in process.stderr
    return folder / "clone"


def fields(path):
    """Return {(load, field): numbers} of a result file."""
    with h5py.File(path, "r") as file:
        return {
            (load, name): file[f"steps/{load}/{name}"][...]
            for load in file["steps"]
            for name in FIELDS
        }


def test_the_same_on_1_to_4_ranks(clone, tmp_path):
    (tmp_path / "scene.toml").write_text(
        scene_text((2, 16, 4), [0.02, 0.1], output={"path": "out.h5", "fields": list(FIELDS)})
    )
    results = []
    for ranks in (1, 2, 3, 4):
        path = tmp_path / f"{ranks}.h5"
        process = subprocess.run(
            [ALONE, "mpirun", "-n", str(ranks), clone / ".venv/bin/hpc-gfmd"]
            + ["run", "scene.toml", "-o", path],
            cwd=tmp_path,
            env=os.environ | {"HPC_GFMD_CACHE": str(tmp_path / "cache"), "PYTHONPATH": ""},
            capture_output=True,
            text=True,
        )
        assert process.returncode == 0, process.stderr
        assert f"{ranks} rank" in process.stdout
        results.append(fields(path))
    for on_ranks in results[1:]:
        for key, numbers in results[0].items():
            assert np.abs(on_ranks[key] - numbers).max() <= 1e-11 * np.abs(numbers).max(), key
