"""What tests of faults share: a small disk, and the run to which nothing happens."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest
from faults.jobs import call, write_scene

from hpc_gfmd.output.read import read_result


def pytest_collection_modifyitems(items):
    """scripts/test runs these beside all others."""
    for item in items:
        if Path(__file__).parent in item.path.parents:
            item.add_marker(pytest.mark.faults)


@pytest.fixture
def small_disk(tmp_path):
    """small_disk(bytes): a tmpfs of that size, mounted on a folder; skips where that is not
    allowed."""
    mounted = []

    def mount(size, folder=tmp_path / "disk"):
        if os.getuid() != 0 or not shutil.which("mount"):
            pytest.skip("only root can mount a small disk")
        folder.mkdir(exist_ok=True)
        command = ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", folder]
        completed = subprocess.run(command, capture_output=True, text=True, check=False)
        if completed.returncode:
            pytest.skip(f"mounting is not allowed: {completed.stderr.strip()}")
        mounted.append(folder)
        return folder

    yield mount
    for folder in mounted:
        subprocess.run(["umount", "-l", folder], check=False)


@pytest.fixture(scope="session")
def undisturbed(tmp_path_factory):
    """undisturbed(ranks, **how): the result of the run to which nothing happens; how: as for
    jobs.write_scene."""
    made = {}

    def result(ranks, **how):
        key = (ranks, str(how))
        if key not in made:
            path = write_scene(tmp_path_factory.mktemp("undisturbed"), **how)
            job = call("run scene.toml -q", ranks, path.parent)
            assert job.code == 0, job.err
            made[key] = read_result(path)
        return made[key]

    return result
