"""Whether the ranks write a file together, by MPI-IO, or rank 0 writes for all."""

import os
import tempfile
from contextlib import suppress
from pathlib import Path

from .comm import Comm
from .guard import on_rank_0


def io_way(comm: Comm, path: Path) -> str:
    """Return how a file is written: "mpio" (all ranks together) or "serial" (rank 0). Collective.

    With "mpio" opening and closing the file are collective, too.

    Parameters
    ----------
    comm : Comm
        The ranks that have parts of the file's fields.
    path : Path
        The file; its folder exists.

    Returns
    -------
    str
        The same on all ranks.
    """
    import h5py

    if comm.size == 1 or not h5py.get_config().mpi:
        return "serial"
    return "serial" if mpi_io_obstacle(comm, path) else "mpio"


def mpi_io_obstacle(comm: Comm, path: Path) -> str:
    """Return why MPI-IO cannot write a file, "" if it can. Collective.

    The first time for a folder, a file of one byte is made in it, opened by MPI-IO and removed.
    Open MPI needs room in /dev/shm for that; some file systems lack what MPI-IO needs.

    Parameters
    ----------
    comm : MpiComm
        Several ranks; it keeps the answer for each folder.
    path : Path
        The file; its folder exists.

    Returns
    -------
    str
        For a person, the same on all ranks.
    """
    if ":" in os.fspath(path):
        return "it takes what is before a colon for the kind of a file system"
    folder = path.parent
    if folder not in comm.io_obstacles:
        comm.io_obstacles[folder] = _failure_to_open(comm, folder)
    return comm.io_obstacles[folder]


def _failure_to_open(comm: Comm, folder: Path) -> str:
    """Return MPI-IO's error for a new file in a folder, "" if it can be written. Collective.

    Also "" if rank 0 cannot make the file without MPI-IO: writing itself reports that. The file is
    removed again.
    """
    from mpi4py import MPI

    def make_probe() -> str | None:
        """Make a file of one byte; return None if it cannot be made: the writer says why."""
        try:
            descriptor, name = tempfile.mkstemp(prefix=".hpc-gfmd-", dir=folder)
        except OSError:
            return None
        try:
            os.write(descriptor, b"0")
        except OSError:  # such as a full disk
            os.unlink(name)
            return None
        finally:
            os.close(descriptor)
        return name

    probe = on_rank_0(comm, f"writing in {folder}", make_probe)
    if probe is None:
        return ""
    reason = ""
    try:
        file = MPI.File.Open(comm.mpi, probe, MPI.MODE_RDWR)
    except MPI.Exception as error:
        reason = " ".join(error.Get_error_string().split()) or "unknown error"
    failing_rank = int(comm.min([comm.rank if reason else comm.size])[0])
    if failing_rank == comm.size:
        file.Close()  # together: a rank without it would not take part
    if comm.rank == 0:
        with suppress(OSError):
            os.unlink(probe)
    return "" if failing_rank == comm.size else comm.bcast(reason, failing_rank)
