"""Whether an MPI launcher started this process, as environment variables and /proc tell."""

import os
import re
from collections.abc import Iterator
from pathlib import Path

# Numbers of all processes and of this one, set by mpirun (Open MPI, MPICH, Intel MPI, MVAPICH) and
# by srun --mpi=pmix or pmi2.
LAUNCHER_SIZE = ("OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "MV2_COMM_WORLD_SIZE")
LAUNCHER_RANK = ("PMIX_RANK", "PMI_RANK", "OMPI_COMM_WORLD_RANK", "PALS_RANKID")
# Intel MPI's number of ranks on this node: a launcher is there, but the size of the world is not it
LOCAL_SIZE = "MPI_LOCALNRANKS"
# "mpi" or "none", where these variables mislead: of another launcher, or left over from one around
LAUNCHER = "HPC_GFMD_LAUNCHER"

PROC = Path("/proc")
# what the names of processes that start ranks begin with; a person starts the first ones
TERMINAL_LAUNCHERS = ("mpirun", "mpiexec", "orterun", "prterun")
LAUNCHERS = (*TERMINAL_LAUNCHERS, "orted", "prted", "prun", "hydra", "slurmstep")


def launched() -> tuple[bool, int | None]:
    """Return whether an MPI launcher started this process, and how many it started (or None)."""
    setting = os.environ.get(LAUNCHER)
    if setting == "none":
        return False, None
    size = environment_number(*LAUNCHER_SIZE)
    present = any(name in os.environ for name in (*LAUNCHER_RANK, LOCAL_SIZE))
    by_launcher = setting == "mpi" or size is not None or present
    if by_launcher and size is None:
        size = srun_size()  # PMIx tells processes their rank only
    return by_launcher, size


def srun_size() -> int | None:
    """Return the number of processes of this process's Slurm step, or None outside one."""
    return environment_number("SLURM_STEP_NUM_TASKS")


def idle_tasks() -> str:
    """Return a note if this process runs alone in a Slurm job of several tasks, else ""."""
    tasks = environment_number("SLURM_NTASKS") or 1
    alone = not launched()[0] and srun_size() is None and LAUNCHER not in os.environ
    if tasks == 1 or not alone:
        return ""
    return f"the job has {tasks} tasks, of which one is used: start it with srun or mpirun"


def tasks_per_node() -> int | None:
    """Return the number of processes on the fullest node of the Slurm job, None outside Slurm."""
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


def ancestors(proc: Path = PROC) -> Iterator[tuple[Path, str]]:
    """Yield (folder in /proc, name) of parent, grandparent, ... without process 1."""
    pid = os.getppid()
    try:
        while pid > 1:
            # pid (name) state parent ...; the name may hold spaces and brackets
            head, _, tail = (proc / f"{pid}/stat").read_text().rpartition(")")
            yield proc / str(pid), head.partition("(")[2]
            pid = int(tail.split()[1])
    except (OSError, ValueError, IndexError):
        pass


def enclosing_mpi_program(proc: Path = PROC) -> str | None:
    """Return the MPI program, as an optimiser, that started this process without a launcher, or
    None: with its rank's variables MPI would abort in a second process.
    """
    try:
        for folder, name in ancestors(proc):
            if name.startswith(LAUNCHERS):
                return None
            if b"/libmpi" in (folder / "maps").read_bytes():
                words = (folder / "cmdline").read_bytes().split(b"\0")
                return b" ".join(words).decode(errors="replace").strip()
    except OSError:
        pass
    return None


def launcher_is_watched(proc: Path = PROC) -> bool:
    """Return whether mpirun writes its errors to a terminal; this process has a pipe to it."""
    for folder, name in ancestors(proc):
        if name.startswith(TERMINAL_LAUNCHERS):
            try:
                return os.readlink(folder / "fd/2").startswith(("/dev/pts/", "/dev/tty"))
            except OSError:
                return False
    return False
