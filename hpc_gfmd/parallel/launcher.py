"""Whether and by what this process was started as one of several."""

import os
import re

# Set by mpirun (Open MPI, MPICH, Intel MPI) and by srun --mpi=pmix/pmi2 for every process that they
# start.
LAUNCHER_SIZE = ("OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "MV2_COMM_WORLD_SIZE", "MPI_LOCALNRANKS")
LAUNCHER_RANK = ("PMIX_RANK", "PMI_RANK", "OMPI_COMM_WORLD_RANK", "PALS_RANKID")
# "mpi" or "none", where these variables mislead: of another launcher, or left over from one around
LAUNCHER = "HPC_GFMD_LAUNCHER"


def launched() -> tuple[bool, int | None]:
    """Tell whether an MPI launcher started this process, and the number of processes if the
    launcher tells it (else None).

    The variable HPC_GFMD_LAUNCHER says "mpi" or "none" where that cannot be seen.
    """
    said = os.environ.get(LAUNCHER)
    if said == "none":
        return False, None
    size = number_in(*LAUNCHER_SIZE)
    by_launcher = said == "mpi" or size is not None or any(k in os.environ for k in LAUNCHER_RANK)
    if by_launcher and size is None:
        size = srun_size()  # PMIx tells processes their rank only
    return by_launcher, size


def srun_size() -> int | None:
    """Return the number of processes that srun started with this one, or None."""
    return number_in("SLURM_STEP_NUM_TASKS")


def tasks_per_node() -> int | None:
    """Return the number of processes on each node (the fullest one) of the Slurm job around this
    process, or None."""
    said = os.environ.get("SLURM_NTASKS_PER_NODE") or os.environ.get("SLURM_TASKS_PER_NODE", "")
    # the latter as in "16(x3),8"
    found = [int(number) for number in re.findall(r"(?:^|,)(\d+)", said)]
    return max(found, default=0) or None


def launcher_rank() -> int:
    """Return this process's number as the launcher tells it; 0 without a launcher."""
    if os.environ.get(LAUNCHER) == "none":
        return 0
    return number_in(*LAUNCHER_RANK, "SLURM_PROCID") or 0


def number_in(*names: str) -> int | None:
    """Read the first of these environment variables that is a whole number; None without one."""
    return next((int(text) for name in names if (text := os.environ.get(name, "")).isdigit()), None)
