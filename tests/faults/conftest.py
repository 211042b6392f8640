"""Fixtures of the tests of faults: a small disk, and results of undisturbed runs."""

import os
import shutil
import subprocess

import pytest
from faults.jobs import call, write_scene

from hpc_gfmd.output.read import read_result


@pytest.fixture
def small_disk(tmp_path):
    """small_disk(bytes) mounts a tmpfs of that size and returns its folder, or skips the test."""
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
    """undisturbed(ranks, **settings) returns the result of a run without faults.

    settings: arguments of jobs.write_scene.
    """
    results = {}

    def result(ranks, **settings):
        key = (ranks, str(settings))
        if key not in results:
            path = write_scene(tmp_path_factory.mktemp("undisturbed"), **settings)
            job = call("run scene.toml -q", ranks, path.parent)
            assert job.code == 0, job.err
            results[key] = read_result(path)
        return results[key]

    return result
