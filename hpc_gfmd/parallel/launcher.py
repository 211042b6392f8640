"""Whether and by what this process was started as one of several: environment variables of MPI
launchers and of Slurm."""

import os
import re

# Set by mpirun (Open MPI, MPICH, Intel MPI) and by srun --mpi=pmix/pmi2 for every process that they
# start.
LAUNCHER_SIZE = ("OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "MV2_COMM_WORLD_SIZE", "MPI_LOCALNRANKS")
LAUNCHER_RANK = ("PMIX_RANK", "PMI_RANK", "OMPI_COMM_WORLD_RANK", "PALS_RANKID")
# "mpi" or "none", where these variables mislead: of another launcher, or left over from one around
LAUNCHER = "HPC_GFMD_LAUNCHER"


def launched() -> tuple[bool, int | None]:
    """Return whether an MPI launcher started this process, and how many processes it started.

    The number is None if the launcher does not tell it. The environment variable HPC_GFMD_LAUNCHER
    overrides what other variables say: "mpi" or "none".
    """
    setting = os.environ.get(LAUNCHER)
    if setting == "none":
        return False, None
    size = environment_number(*LAUNCHER_SIZE)
    has_rank = any(name in os.environ for name in LAUNCHER_RANK)
    by_launcher = setting == "mpi" or size is not None or has_rank
    if by_launcher and size is None:
        size = srun_size()  # PMIx tells processes their rank only
    return by_launcher, size


def srun_size() -> int | None:
    """Return the number of processes of this process's Slurm step, or None outside Slurm."""
    return environment_number("SLURM_STEP_NUM_TASKS")


def tasks_per_node() -> int | None:
    """Return the number of processes on the fullest node of the Slurm job around this process.

    None outside Slurm, or if Slurm does not tell it.
    """
    text = os.environ.get("SLURM_NTASKS_PER_NODE") or os.environ.get("SLURM_TASKS_PER_NODE", "")
    # the latter as in "16(x3),8"
    counts = [int(digits) for digits in re.findall(r"(?:^|,)(\d+)", text)]
    return max(counts, default=0) or None


def launcher_rank() -> int:
    """Return the number of this process as the launcher or Slurm tells it; 0 without one."""
    if os.environ.get(LAUNCHER) == "none":
        return 0
    return environment_number(*LAUNCHER_RANK, "SLURM_PROCID") or 0


def environment_number(*names: str) -> int | None:
    """Return the first of these environment variables that is a whole number; None if none is."""
    for name in names:
        text = os.environ.get(name, "")
        if text.isdigit():
            return int(text)
    return None
