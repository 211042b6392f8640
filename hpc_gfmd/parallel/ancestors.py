"""The processes that started this one, as far as /proc shows them: an MPI launcher, and what is
between it and this process."""

import os
import stat
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from .launcher import LAUNCHER_RANK

PROC = Path("/proc")
# what the names of MPI's own libraries begin with: libmpi.so.40, libmpich.so.12, libmpi_cray.so
LIBRARY = b"/libmpi"
# what the names of processes that start ranks begin with
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
TERMINAL_LAUNCHERS = ("mpirun", "mpiexec", "orterun", "prterun")  # those that a person starts
# major numbers of Linux's terminals: consoles, serial lines and pseudo-terminals
TERMINALS = (4, 5, 204, *range(136, 144))


class Process(NamedTuple):
    """A running process.

    Attributes
    ----------
    pid : int
        Its number.
    name : str
        The first 15 characters of its name.
    """

    pid: int
    name: str


def ancestors(proc: Path = PROC) -> Iterator[Process]:
    """Yield the parent of this process, its parent and so on, up to process 1, which is left out.

    Ends early if /proc cannot be read.
    """
    pid = os.getppid()
    try:
        while pid > 1:
            # pid (name) state parent ...; the name may hold spaces and brackets
            head, _, tail = (proc / f"{pid}/stat").read_text().rpartition(")")
            yield Process(pid, head.partition("(")[2])
            pid = int(tail.split()[1])
    except (OSError, ValueError, IndexError):
        pass


def enclosing_mpi_program(proc: Path = PROC) -> str | None:
    """Return the command line of the rank of another MPI program that started this process.

    Such a program may be an optimiser that runs under mpirun itself. This process then has the
    variables of that rank, and MPI kills a second process that uses them. An ancestor with the same
    rank is a rank if it has loaded an MPI library; a shell or another wrapper between the launcher
    and this process has not. None if there is no such program, or /proc cannot be read.
    """
    variables = {name: os.environ[name] for name in LAUNCHER_RANK if name in os.environ}
    if not variables:
        return None
    wanted = {f"{name}={value}".encode() for name, value in variables.items()}
    try:
        for pid, name in ancestors(proc):
            environment = set((proc / f"{pid}/environ").read_bytes().split(b"\0"))
            if name.startswith(LAUNCHERS) or not wanted <= environment:
                return None
            if LIBRARY in (proc / f"{pid}/maps").read_bytes():
                words = (proc / f"{pid}/cmdline").read_bytes().split(b"\0")
                return b" ".join(words).decode(errors="replace").strip()
    except OSError:
        pass
    return None


def launcher_is_watched(proc: Path = PROC) -> bool:
    """Return whether the mpirun that started this process writes its errors to a terminal.

    (Standard error of this process is a pipe to mpirun.) False without an mpirun, or if /proc
    cannot be read.
    """
    for pid, name in ancestors(proc):
        if name.startswith(TERMINAL_LAUNCHERS):
            try:
                status = os.stat(proc / f"{pid}/fd/2")
            except OSError:
                return False
            return stat.S_ISCHR(status.st_mode) and os.major(status.st_rdev) in TERMINALS
    return False
