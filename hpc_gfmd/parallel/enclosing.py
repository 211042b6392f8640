"""Whether this process was started by a rank of another MPI program, such as an optimiser that runs
under mpirun itself: it has the variables of that rank, and MPI ends a second process that uses
them."""

import os
from pathlib import Path

from .launcher import LAUNCHER_RANK

# what the names of MPI's own libraries begin with: libmpi.so.40, libmpich.so.12, libmpi_cray.so
LIBRARY = b"/libmpi"
# names of processes that start ranks: what is around them is not around these ranks
LAUNCHERS = (
    "mpirun",
    "mpiexec",
    "orterun",
    "orted",
    "prterun",
    "prted",
    "prun",
    "hydra",
    "slurmstep",
)


def enclosing_mpi_program(proc: Path = Path("/proc")) -> str | None:
    """Return the command line of the rank that started this process, or None.

    An ancestor with the same rank is a rank if it has loaded an MPI library: a shell or another
    wrapper between the launcher and this process has not. None as well where the system does not
    tell.
    """
    variables = {name: os.environ[name] for name in LAUNCHER_RANK if name in os.environ}
    if not variables:
        return None
    wanted = {f"{name}={value}".encode() for name, value in variables.items()}
    pid = os.getppid()
    try:
        while pid > 1 and wanted <= set((proc / f"{pid}/environ").read_bytes().split(b"\0")):
            # pid (name) state parent ...; the name may hold spaces and brackets
            head, _, tail = (proc / f"{pid}/stat").read_text().rpartition(")")
            if head.partition("(")[2].startswith(LAUNCHERS):
                return None
            if LIBRARY in (proc / f"{pid}/maps").read_bytes():
                words = (proc / f"{pid}/cmdline").read_bytes().split(b"\0")
                return b" ".join(words).decode(errors="replace").strip()
            pid = int(tail.split()[1])
    except (OSError, ValueError):
        pass
    return None
