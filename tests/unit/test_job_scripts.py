"""Functions of the job scripts that work without Slurm: exit codes follow from the files of a run,
not from the launcher."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.skipif(shutil.which("bash") is None, reason="needs bash")
# stand-ins for mpirun: leave the files of a run and return an exit code
LAUNCHERS = {
    "finished": "touch out.h5; exit 0",
    "less accurate": "touch out.h5; exit 3",
    "interrupted": "mkdir out.h5.partial; exit 0",
    "interrupted, with an older result": "touch out.h5; mkdir out.h5.partial; exit 0",
    "lost": "exit 0",
    "refused": "exit 2",
    "stopped": "mkdir out.h5.partial; exit 143",
}
CODES = dict(zip(LAUNCHERS, (0, 3, 143, 143, 1, 2, 143), strict=True))


@pytest.mark.parametrize("kind", LAUNCHERS)
def test_exit_codes_follow_from_files(kind, tmp_path):
    mpirun = tmp_path / "mpirun"
    mpirun.write_text(f"#!/bin/bash\necho started >>log\n{LAUNCHERS[kind]}\n")
    mpirun.chmod(0o755)
    (tmp_path / "python").symlink_to(sys.executable)
    env = os.environ | {
        "PATH": f"{tmp_path}{os.pathsep}{os.environ['PATH']}",
        "LAUNCHER": "mpirun",
        "SLURM_NTASKS": "2",
        "root": str(ROOT),
    }
    script = f"source {ROOT}/slurm/launch.sh; solve scene.toml out.h5"

    def code():
        command = ["bash", "-c", script]
        return subprocess.run(command, cwd=tmp_path, env=env, capture_output=True).returncode

    assert code() == CODES[kind]
    if kind in ("finished", "less accurate"):
        assert code() == 0
        assert (tmp_path / "log").read_text() == "started\n"
