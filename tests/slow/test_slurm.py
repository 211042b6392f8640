"""The job scripts of slurm/ under a real Slurm on this machine."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
CAN_RUN = (
    os.geteuid() == 0
    and shutil.which("mpirun")
    and (shutil.which("slurmctld") or shutil.which("apt-get"))
)


@pytest.mark.slow
@pytest.mark.alone
@pytest.mark.skipif(not CAN_RUN, reason="needs root, mpirun, and Slurm or apt-get to install it")
@pytest.mark.parametrize("part", ["mpirun", "srun", "array", "scaling", "chain", "startup"])
def test_jobs_of_one_machine(part):
    process = subprocess.run(
        [ROOT / "scripts" / "slurm-test", part],
        capture_output=True,
        text=True,
        timeout=1800,
        check=False,
    )
    assert process.returncode == 0, process.stdout + process.stderr
