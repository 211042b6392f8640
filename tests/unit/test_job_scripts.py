"""What of the job scripts works without Slurm: exit codes follow from the files of a run, not from
the launcher, and a study is started with arguments that exist."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from paper.__main__ import make_parser

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


def with_launcher(folder, text):
    """Make a folder's mpirun of lines of bash; return the environment of a job that finds it."""
    mpirun = folder / "mpirun"
    mpirun.write_text(f"#!/bin/bash\n{text}\n")
    mpirun.chmod(0o755)
    path = f"{folder}{os.pathsep}{os.environ['PATH']}"
    return os.environ | {"PATH": path, "LAUNCHER": "mpirun", "SLURM_NTASKS": "2"}


@pytest.mark.parametrize("kind", LAUNCHERS)
def test_exit_codes_follow_from_files(kind, tmp_path):
    env = with_launcher(tmp_path, f"echo started >>log\n{LAUNCHERS[kind]}")
    (tmp_path / "python").symlink_to(sys.executable)
    script = f"source {ROOT}/slurm/launch.sh; solve scene.toml out.h5"

    def code():
        command = ["bash", "-c", script]
        return subprocess.run(command, cwd=tmp_path, env=env, capture_output=True).returncode

    assert code() == CODES[kind]
    if kind in ("finished", "less accurate"):
        assert code() == 0
        assert (tmp_path / "log").read_text() == "started\n"


def test_a_study_is_one_job(tmp_path):
    env = with_launcher(tmp_path, 'printf "%s\\n" "$@" >words')
    env |= {"HPC_GFMD_ROOT": str(ROOT), "HPC_GFMD_CACHE": str(tmp_path / "cache"), "STUDY": "fig1"}
    job = ["bash", str(ROOT / "slurm/study-array.sbatch")]
    subprocess.run(job, cwd=tmp_path, env=env, check=True, capture_output=True)
    words = (tmp_path / "words").read_text().split()
    assert words[:4] == ["-n", "2", "python", f"{ROOT}/scripts/paper"]
    args = make_parser().parse_args(words[4:])
    assert (args.item, args.level, args.output) == (["fig1"], "desk", "study-desk")
