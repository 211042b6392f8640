"""A machine whose only MPI is Debian's MPICH, which mpi4py's wheel does not know: set up as on any
other, with the same results."""

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
    pytest.mark.skipif(os.getuid() != 0, reason="only root can hide the other MPI"),
    pytest.mark.skipif(
        bool(MISSING),
        reason="needs Debian's mpich, libmpich-dev, libhdf5-mpich-dev beside Open MPI",
    ),
]


@pytest.fixture(scope="module")
def clone(tmp_path_factory):
    """A clone that scripts/setup has set up with MPICH alone: compiles for some minutes."""
    folder = tmp_path_factory.mktemp("mpich")
    listed = subprocess.check_output(["git", "ls-files", "-z"], cwd=ROOT).split(b"\0")[:-1]
    for name in map(os.fsdecode, listed):
        (folder / "clone" / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / name, folder / "clone" / name)
    done = subprocess.run(
        [ALONE, folder / "clone" / "scripts" / "setup"],
        env=os.environ | {"XDG_CACHE_HOME": str(folder / "cache")},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    assert "compiling mpi4py" in done.stderr
    return folder / "clone"


def fields(path):
    """{(load, field): numbers} of a result file."""
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
        done = subprocess.run(
            [ALONE, "mpirun", "-n", str(ranks), clone / ".venv/bin/hpc-gfmd"]
            + ["run", "scene.toml", "-o", path],
            cwd=tmp_path,
            env=os.environ | {"HPC_GFMD_CACHE": str(tmp_path / "cache"), "PYTHONPATH": ""},
            capture_output=True,
            text=True,
        )
        assert done.returncode == 0, done.stderr
        assert f"{ranks} rank" in done.stdout
        results.append(fields(path))
    for found in results[1:]:
        for key, numbers in results[0].items():
            assert np.abs(found[key] - numbers).max() <= 1e-11 * np.abs(numbers).max(), key
