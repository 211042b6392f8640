"""The communicator: a thin layer over MPI, or a stand-in for one process."""

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from .shared import can_share

T = TypeVar("T")


class SerialComm:
    """One process: every reduction is the identity.

    Parameters
    ----------
    parent : Comm, optional
        The communicator that this is a part of.

    Attributes
    ----------
    rank, size : int
        Number of this process, and of all.
    mpi : mpi4py communicator or None
        What is below.
    io_obstacles : dict
        Why MPI-IO cannot write, for each folder that was tried.
    node_ranks : ndarray of int
        Ranks that have memory in common with this one.
    """

    rank = 0
    size = 1
    mpi: Any = None
    io_obstacles: dict[Path, str] = {}

    def __init__(self, parent: "Comm | None" = None):
        self.parent = parent

    def sum(self, values: ArrayLike) -> np.ndarray:
        """Sum over ranks of each number; returns an array of float64."""
        return np.asarray(values, dtype=np.float64)

    max = min = sum

    def bcast(self, obj: Any, root: int = 0) -> Any:
        """Return the object of one rank on all ranks. Collective.

        Parameters
        ----------
        obj : object
            Of this rank; what the others give is not looked at.
        root : int
            The rank.

        Returns
        -------
        object
            Of that rank.
        """
        return obj

    def allgather(self, obj: Any) -> list:
        """Return the list of every rank's object."""
        return [obj]

    def gather(self, obj: Any) -> list | None:
        """Return the list of every rank's object on rank 0, None on the others."""
        return [obj]

    def exchange(self, send: Mapping[int, np.ndarray], receive: Mapping[int, np.ndarray]) -> None:
        """Pass messages between two ranks each. Collective for those that take part.

        Parameters
        ----------
        send : dict of ndarray
            What goes to each rank; contiguous.
        receive : dict of ndarray
            Arrays that are filled from each rank; contiguous.
        """

    def allgather_arrays(self, send: np.ndarray, receive: np.ndarray, counts: list[int]) -> None:
        """Hand the numbers of every rank to all. Collective.

        Parameters
        ----------
        send : flat array
            Of this rank.
        receive : flat array
            Filled with those of all ranks, one after the other.
        counts : list of int
            How many numbers each rank has.
        """
        receive[...] = send

    def alltoall_bytes(self, send: tuple, receive: tuple) -> None:
        """Pass bytes from all ranks to all. Collective.

        Parameters
        ----------
        send, receive : tuple
            (array, bytes for or from each rank, their offsets).
        """

    def reduce(self, obj: T, join: Callable[[T, T], T]) -> T | None:
        """Join the objects of all ranks, two neighbours at a time. Collective.

        Parameters
        ----------
        obj : object
            Of this rank.
        join : function
            join(object of some ranks, object of the ranks after them) returns that of all of them.

        Returns
        -------
        object or None
            That of all ranks on rank 0, None on the others.
        """
        return obj

    def subcomm(self, ranks: Sequence[int]) -> "Comm | None":
        """Return the communicator of these ranks alone, rank 0 first; None on others."""
        return self

    def barrier(self) -> None:
        """Wait for all ranks."""

    @property
    def machine(self) -> "Comm":
        """The communicator of the ranks on the same machine."""
        return self

    node = machine  # of those that have memory in common with this one
    node_ranks = np.zeros(1, int)  # these ranks


def stages(size: int) -> int:
    """Return how many messages a rank sends in a reduction over `size` ranks, by recursive
    doubling."""
    return (size - 1).bit_length()


class MpiComm:
    """A thin layer over an mpi4py communicator, with the same methods as `SerialComm`.

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
    io_obstacles : dict
        Why MPI-IO cannot write, for each folder that was tried (parallel/mpi_io.py).
    """

    def __init__(self, mpi: Any, parent: "MpiComm | None" = None):
        self.mpi = mpi
        self.parent = parent
        self.rank = mpi.Get_rank()
        self.size = mpi.Get_size()
        self.allgather = mpi.allgather
        self.gather = mpi.gather
        self._among: dict[tuple[int, ...], Comm | None] = {}
        self.io_obstacles: dict[Path, str] = {}  # of parallel.mpi_io, for each folder

    def _allreduce(self, values: ArrayLike, op: str) -> np.ndarray:
        """Reduce each number over all ranks; op: of MPI, such as "SUM". Collective."""
        from mpi4py import MPI

        send = np.ascontiguousarray(values, dtype=np.float64)
        recv = np.empty_like(send)
        self.mpi.Allreduce(send, recv, op=getattr(MPI, op))
        return recv

    def sum(self, values: ArrayLike) -> np.ndarray:
        """Sum over ranks of each number; returns an array of float64. Collective."""
        return self._allreduce(values, "SUM")

    def max(self, values: ArrayLike) -> np.ndarray:
        """Largest of all ranks of each number; returns an array of float64. Collective."""
        return self._allreduce(values, "MAX")

    def min(self, values: ArrayLike) -> np.ndarray:
        """Smallest of all ranks of each number; returns an array of float64. Collective."""
        return self._allreduce(values, "MIN")

    def bcast(self, obj: Any, root: int = 0) -> Any:
        """Return the object of one rank on all ranks. Collective.

        Parameters
        ----------
        obj : object
            Of this rank, pickled; what the others give is not looked at.
        root : int
            The rank.

        Returns
        -------
        object
            Of that rank.
        """
        return self.mpi.bcast(obj, root=root)

    def exchange(self, send: Mapping[int, np.ndarray], receive: Mapping[int, np.ndarray]) -> None:
        """Pass messages between two ranks each, all at once. Collective for those that take part.

        Parameters
        ----------
        send : dict of ndarray
            What goes to each rank; contiguous.
        receive : dict of ndarray
            Arrays that are filled from each rank; contiguous.
        """
        from mpi4py import MPI

        requests = [self.mpi.Irecv(a, source=rank) for rank, a in receive.items()]
        requests += [self.mpi.Isend(a, dest=rank) for rank, a in send.items()]
        MPI.Request.Waitall(requests)

    def allgather_arrays(self, send: np.ndarray, receive: np.ndarray, counts: list[int]) -> None:
        """Hand the numbers of every rank to all. Collective.

        Parameters
        ----------
        send : flat array
            Of this rank.
        receive : flat array
            Filled with those of all ranks, one after the other.
        counts : list of int
            How many numbers each rank has.
        """
        self.mpi.Allgatherv(send, [receive, counts])

    def alltoall_bytes(self, send: tuple, receive: tuple) -> None:
        """Pass bytes from all ranks to all. Collective.

        Parameters
        ----------
        send, receive : tuple
            (array, bytes for or from each rank, their offsets).
        """
        from mpi4py import MPI

        self.mpi.Alltoallv(
            [send[0].view(np.uint8), *send[1:], MPI.BYTE],
            [receive[0].view(np.uint8), *receive[1:], MPI.BYTE],
        )

    def reduce(self, obj: T, join: Callable[[T, T], T]) -> T | None:
        """Join the objects of all ranks up a tree. Collective.

        A rank receives at most ceil(log2(ranks)) messages.

        Parameters
        ----------
        obj : object
            Of this rank, pickled.
        join : function
            join(object of some ranks, object of the ranks after them) returns that of all of them.

        Returns
        -------
        object or None
            That of all ranks on rank 0, None on the others.
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
        """Return the communicator of these ranks alone, rank 0 first; None on others. Made once:
        MPI has few of them. Collective."""
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

    @cached_property
    def machine(self) -> "Comm":
        """The communicator of the ranks on the same machine. Collective where it is asked for
        first."""
        return MpiComm(same_machine(self.mpi), self)

    @cached_property
    def node(self) -> "Comm":
        """That of the ranks that have memory in common with this one: all on the machine, or none.
        Collective as `machine`."""
        if self.machine.size > 1 and can_share(self.machine):
            return self.machine
        return SerialComm(self)

    @cached_property
    def node_ranks(self) -> np.ndarray:
        """The numbers of these ranks, ascending. Collective as `node`."""
        return np.array(self.node.allgather(self.rank))


class DryRunComm:
    """The communicator of a rank that does not exist: it knows who is where, and cannot send.

    Parameters
    ----------
    rank, size : int
        Number of the rank, and of all.
    nodes : ndarray of int, shape (size,)
        Number of the node of every rank; between nodes everything is a message.
    """

    mpi = parent = None

    def __init__(self, rank: int, size: int, nodes: np.ndarray):
        self.rank = rank
        self.size = size
        self._nodes = nodes

    @property
    def node_ranks(self) -> np.ndarray:
        """The ranks on the same node."""
        return np.flatnonzero(self._nodes == self._nodes[self.rank])

    def subcomm(self, ranks: list[int]) -> "DryRunComm | None":
        """Return the communicator of these ranks alone, None where this rank is not one of them."""
        if self.rank not in ranks:
            return None
        return DryRunComm(ranks.index(self.rank), len(ranks), self._nodes[ranks])


Comm = SerialComm | MpiComm


def same_machine(mpi: Any) -> Any:
    """Return the part of an mpi4py communicator that is on one machine. Collective."""
    from mpi4py import MPI

    return mpi.Split_type(MPI.COMM_TYPE_SHARED, mpi.Get_rank())
