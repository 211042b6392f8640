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
    """Whether an MPI launcher started this process, and the number of processes if the launcher
    tells it (else None).

    The variable HPC_GFMD_LAUNCHER says "mpi" or "none" where that cannot be seen.
    """
    said = os.environ.get(LAUNCHER)
    if said == "none":
        return False, None
    size = next(
        (int(os.environ[k]) for k in LAUNCHER_SIZE if os.environ.get(k, "").isdigit()), None
    )
    by_launcher = said == "mpi" or size is not None or any(k in os.environ for k in LAUNCHER_RANK)
    if by_launcher and size is None:
        size = srun_size()  # PMIx tells processes their rank only
    return by_launcher, size


def srun_size() -> int | None:
    """Number of processes that srun started with this one, or None."""
    text = os.environ.get("SLURM_STEP_NUM_TASKS", "")
    return int(text) if text.isdigit() else None


def tasks_per_node() -> int | None:
    """Number of processes on each node (the fullest one) of the Slurm job around this process, or
    None."""
    said = os.environ.get("SLURM_NTASKS_PER_NODE") or os.environ.get(
        "SLURM_TASKS_PER_NODE", ""
    )  # the latter as in "16(x3),8"
    found = [int(number) for number in re.findall(r"(?:^|,)(\d+)", said)]
    return max(found, default=0) or None


def launcher_rank() -> int:
    """This process's number as the launcher tells it; 0 without a launcher."""
    if os.environ.get(LAUNCHER) == "none":
        return 0
    return next(
        (
            int(os.environ[k])
            for k in (*LAUNCHER_RANK, "SLURM_PROCID")
            if os.environ.get(k, "").isdigit()
        ),
        0,
    )
