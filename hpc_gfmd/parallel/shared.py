"""Memory that the ranks of a node share, each reading and writing the parts of others directly.

It is a file without a name (memfd): needs no room in /dev/shm and goes with the last process. MPI's
windows would have to be freed by all ranks together, which Python's objects cannot promise.
"""

import mmap
import os
from typing import Any

import numpy as np

PAGE = mmap.PAGESIZE


def common_memory(comm: Any, nbytes: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the bytes, zeros, of memory that all ranks share, and where each rank's begin.
    Collective. Ranks synchronise themselves; OSError on all if they cannot share.
    """
    offsets = np.concatenate([[0], np.cumsum(-(-np.array(comm.allgather(nbytes)) // PAGE) * PAGE)])
    total = max(int(offsets[-1]), PAGE)
    file = -1  # of rank 0
    error = None
    memory = None
    token = int.from_bytes(os.urandom(6))
    if comm.rank == 0:
        try:
            file = os.memfd_create(_name(token))
            os.ftruncate(file, total)
        except (OSError, AttributeError) as caught:  # a system without them
            error = OSError(str(caught))
    pid, descriptor, token = comm.bcast((os.getpid(), -1 if error else file, token))
    try:
        if descriptor >= 0:
            memory = _mapped(f"/proc/{pid}/fd/{descriptor}", token, total)
    except OSError as caught:
        error = caught
    failed = comm.max([memory is None])[0]  # all have opened it, or given up
    if file >= 0:
        os.close(file)
    if failed or memory is None:
        raise error or OSError("no memory in common with another rank")
    return memory, offsets[:-1]


def _name(token: int) -> str:
    """Return the name of the memory with this token, a random number."""
    return f"hpc-gfmd-{token}"


def _mapped(path: str, token: int, total: int) -> np.ndarray:
    """Map the shared memory at a path of /proc, or raise OSError if it does not have this token."""
    if os.readlink(path) != f"/memfd:{_name(token)} (deleted)":
        raise FileNotFoundError(f"{path}: of another process, as in another container")
    file = os.open(path, os.O_RDWR)
    try:
        mapped = mmap.mmap(file, total)
    finally:
        os.close(file)
    if hasattr(mmap, "MADV_HUGEPAGE"):
        try:
            mapped.madvise(mmap.MADV_HUGEPAGE)  # as NumPy does for what it allocates
        except OSError:  # a system without them
            pass
    return np.frombuffer(mapped, np.uint8)


def can_share(comm: Any) -> bool:
    """Return whether the ranks of a communicator can share memory, by trying it. Collective."""
    try:
        common_memory(comm, 0)
    except OSError:
        return False
    return True
