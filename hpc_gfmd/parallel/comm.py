"""The communicator: a thin layer over MPI, or a stand-in for one process."""

import time
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from math import inf
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from .shared import can_share

T = TypeVar("T")

SHORTEST_PAUSE = 1e-4  # seconds between two looks of a rank that waits asleep, doubled each time
LONGEST_PAUSE = 0.01


class SerialComm:
    """The communicator of a single process, with the methods of `MpiComm`: nothing is sent."""

    rank = 0
    size = 1
    mpi: Any = None

    def __init__(self, parent: "Comm | None" = None):
        self.parent = parent

    def sum(self, values: ArrayLike) -> np.ndarray:
        """Return the numbers of the one rank, also their `max` and `min`, as float64."""
        return np.asarray(values, dtype=np.float64)

    max = min = sum

    def bcast(self, obj: Any, root: int = 0) -> Any:
        """Return `obj` itself."""
        return obj

    def allgather(self, obj: Any) -> list:
        """Return the list of every rank's object: [obj]."""
        return [obj]

    def gather(self, obj: Any) -> list | None:
        """Return the list of every rank's object on rank 0, which this is: [obj]."""
        return [obj]

    def exchange(self, send: Mapping[int, np.ndarray], receive: Mapping[int, np.ndarray]) -> None:
        """Do nothing: both dicts must be empty."""

    def allgather_arrays(self, send: np.ndarray, receive: np.ndarray, counts: list[int]) -> None:
        """Copy the array of this rank to `receive`."""
        receive[...] = send

    def alltoall_bytes(self, send: tuple, receive: tuple) -> None:
        """Do nothing: the number of bytes of this rank for itself must be 0."""

    def reduce(self, obj: T, join: Callable[[T, T], T]) -> T | None:
        """Return the object of this rank."""
        return obj

    def subcomm(self, ranks: Sequence[int]) -> "Comm | None":
        """Return this communicator; `ranks`, which is [0], is not looked at."""
        return self

    def barrier(self) -> None:
        """Do nothing: there is no rank to wait for."""

    def wait_asleep(self, seconds: float = inf) -> bool:
        """Return True: there is no rank to wait for."""
        return True

    @property
    def machine(self) -> "Comm":
        """The communicator of the ranks on the same machine: this one."""
        return self

    node = machine  # of those that have memory in common with this one
    node_ranks = np.zeros(1, int)  # these ranks


class MpiComm:
    """A thin layer over an mpi4py communicator; all methods but `exchange` are collective.

    Parameters
    ----------
    mpi : mpi4py communicator
        What is below.
    parent : Comm, optional
        The communicator that this is a part of.

    Attributes
    ----------
    rank, size : int
        Number of this process, and of all.
    allgather, gather : methods
        Of mpi4py: the pickled objects of all ranks as a list, on every rank or on rank 0 alone.
    """

    def __init__(self, mpi: Any, parent: "MpiComm | None" = None):
        self.mpi = mpi
        self.parent = parent
        self.rank = mpi.Get_rank()
        self.size = mpi.Get_size()
        self.allgather = mpi.allgather
        self.gather = mpi.gather
        self._among: dict[tuple[int, ...], Comm | None] = {}

    def _allreduce(self, values: ArrayLike, op: str) -> np.ndarray:
        """Reduce each number over all ranks to a new array of float64; op as "SUM"."""
        from mpi4py import MPI

        send = np.ascontiguousarray(values, dtype=np.float64)
        recv = np.empty_like(send)
        self.mpi.Allreduce(send, recv, op=getattr(MPI, op))
        return recv

    def sum(self, values: ArrayLike) -> np.ndarray:
        """Return the sum over ranks of each number, an array of float64. Collective."""
        return self._allreduce(values, "SUM")

    def max(self, values: ArrayLike) -> np.ndarray:
        """Return the largest of all ranks for each number, an array of float64. Collective."""
        return self._allreduce(values, "MAX")

    def min(self, values: ArrayLike) -> np.ndarray:
        """Return the smallest of all ranks for each number, an array of float64. Collective."""
        return self._allreduce(values, "MIN")

    def bcast(self, obj: Any, root: int = 0) -> Any:
        """Return the object of rank `root`, pickled, on all ranks."""
        return self.mpi.bcast(obj, root=root)

    def exchange(self, send: Mapping[int, np.ndarray], receive: Mapping[int, np.ndarray]) -> None:
        """Send and receive contiguous arrays by rank, all at once; both sides must name each array,
        in one size. Collective for those ranks.
        """
        from mpi4py import MPI

        requests = [self.mpi.Irecv(a, source=rank) for rank, a in receive.items()]
        requests += [self.mpi.Isend(a, dest=rank) for rank, a in send.items()]
        MPI.Request.Waitall(requests)

    def allgather_arrays(self, send: np.ndarray, receive: np.ndarray, counts: list[int]) -> None:
        """Fill `receive` with the flat arrays of all ranks, each of `counts` numbers."""
        self.mpi.Allgatherv(send, [receive, counts])

    def alltoall_bytes(self, send: tuple, receive: tuple) -> None:
        """Send bytes from every rank to every other; send, receive: (contiguous array, bytes for or
        from each rank, their offsets). Other bytes stay.
        """
        from mpi4py import MPI

        self.mpi.Alltoallv(
            [send[0].view(np.uint8), *send[1:], MPI.BYTE],
            [receive[0].view(np.uint8), *receive[1:], MPI.BYTE],
        )

    def reduce(self, obj: T, join: Callable[[T, T], T]) -> T | None:
        """Return on rank 0 (else None) the objects of all ranks joined up a tree in order of the
        ranks; a rank receives at most ceil(log2(ranks)) messages.
        """
        step = 1
        while step < self.size:
            if self.rank % (2 * step):
                self.mpi.send(obj, dest=self.rank - step)
                return None
            if self.rank + step < self.size:
                obj = join(obj, self.mpi.recv(source=self.rank + step))
            step *= 2
        return obj

    def subcomm(self, ranks: Sequence[int]) -> "Comm | None":
        """Return the communicator of these ranks (ascending), None on others; made once and kept,
        since MPI has a limited number.
        """
        from mpi4py import MPI

        ranks = tuple(map(int, ranks))
        if len(ranks) == self.size:
            return self
        if ranks not in self._among:
            mpi = self.mpi.Split(0 if self.rank in ranks else MPI.UNDEFINED, self.rank)
            made: Comm | None = None
            if mpi != MPI.COMM_NULL:
                made = SerialComm(self) if len(ranks) == 1 else type(self)(mpi, self)
            self._among[ranks] = made
        return self._among[ranks]

    def barrier(self) -> None:
        """Wait for all ranks. Collective."""
        self.mpi.Barrier()

    def wait_asleep(self, seconds: float = inf) -> bool:
        """Wait for all ranks without using a core; if this returns False they must not go on."""
        request = self.mpi.Ibarrier()
        end = time.monotonic() + seconds
        pause = SHORTEST_PAUSE
        while not request.Test():
            if time.monotonic() > end:
                return False
            time.sleep(pause)
            pause = min(2 * pause, LONGEST_PAUSE)
        return True

    @cached_property
    def machine(self) -> "Comm":
        """The communicator of the ranks on the same machine. Collective at the first access."""
        return MpiComm(same_machine(self.mpi), self)

    @cached_property
    def node(self) -> "Comm":
        """The communicator of ranks that share memory with this one. Collective at first access."""
        if self.machine.size > 1 and can_share(self.machine):
            return self.machine
        return SerialComm(self)

    @cached_property
    def node_ranks(self) -> np.ndarray:
        """The numbers of the ranks of `node`, ascending. Collective at the first access."""
        return np.array(self.node.allgather(self.rank))


Comm = SerialComm | MpiComm


def same_machine(mpi: Any) -> Any:
    """Return the mpi4py communicator of those ranks that run on this machine. Collective."""
    from mpi4py import MPI

    return mpi.Split_type(MPI.COMM_TYPE_SHARED, mpi.Get_rank())
