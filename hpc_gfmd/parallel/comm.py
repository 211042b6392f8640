"""The communicator: MPI when an MPI launcher started this process, otherwise a stand-in for one process."""

import os
import sys
import time
from dataclasses import dataclass

import numpy as np

from ..errors import GfmdError, SceneError
from ..streams import unfailing

# Set by mpirun (Open MPI, MPICH, Intel MPI) and by srun --mpi=pmix/pmi2 for every process that they start.
LAUNCHER_SIZE = ("OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "MV2_COMM_WORLD_SIZE", "MPI_LOCALNRANKS")
THREADS_PER_CORE = 8  # more are a mistake
LAUNCHER_RANK = ("PMIX_RANK", "PMI_RANK", "OMPI_COMM_WORLD_RANK", "PALS_RANKID")
LAUNCHER = "HPC_GFMD_LAUNCHER"  # "mpi" or "none", where these variables mislead: of another launcher, or left over from one around


class SerialComm:
    """One process: every reduction is the identity. parent: the communicator that this is a part of."""

    rank, size, mpi = 0, 1, None

    def __init__(self, parent=None):
        self.parent = parent

    def sum(self, values):
        """Sum over ranks of each number; returns an array of float64."""
        return np.asarray(values, dtype=np.float64)

    max = min = sum

    def bcast(self, obj):
        """The object of rank 0."""
        return obj

    def allgather(self, obj):
        """The list of every rank's object."""
        return [obj]

    def gather(self, obj):
        """The list of every rank's object on rank 0, None on the others."""
        return [obj]

    def alltoall(self, objects):
        """The list of what every rank had for this one; objects: one for each rank."""
        return objects

    def counts(self, number):
        """Every rank's whole number, an array."""
        return np.array([number])

    def share(self, values):
        """Rank 0's numbers, an array of float64; the others give as many."""
        return np.asarray(values, dtype=np.float64)

    def exchange(self, send, receive):
        """Messages between two ranks each: send[rank] goes to that rank, receive[rank] is filled from it; contiguous arrays."""

    def pass_on(self, obj, ranks, source):
        """The object of rank `source`; ranks: those that want the object of this one."""
        return obj

    def among(self, ranks):
        """The communicator of these ranks alone, rank 0 first; None on others."""
        return self

    def barrier(self):
        """Wait for all ranks."""


@dataclass
class Traffic:
    """What this rank has sent to others: bytes and messages. A reduction is counted as log2(ranks) messages, as in a tree."""

    bytes: int = 0
    messages: int = 0

    def add(self, nbytes, messages=1):
        """Count messages of so many bytes together."""
        self.bytes += int(nbytes)
        self.messages += int(messages)


def stages(size):
    """How many messages a rank sends in a reduction over so many ranks, by recursive doubling."""
    return (size - 1).bit_length()


class MpiComm:
    """A thin layer over an mpi4py communicator with the same few methods as `SerialComm`; sent: its Traffic, that of parts
    of it counted."""

    def __init__(self, mpi, parent=None):
        self.mpi, self.parent = mpi, parent
        self.rank = mpi.Get_rank()
        self.size = mpi.Get_size()
        self.sent = parent.sent if parent else Traffic()
        self._among = {}

    def _reduce(self, values, op):
        send = np.ascontiguousarray(values, dtype=np.float64)
        recv = np.empty_like(send)
        self.mpi.Allreduce(send, recv, op=op)
        self.sent.add(send.nbytes * stages(self.size), stages(self.size))
        return recv

    def sum(self, values):
        """Sum over ranks of each number; returns an array of float64."""
        from mpi4py import MPI

        return self._reduce(values, MPI.SUM)

    def max(self, values):
        """Largest over ranks of each number."""
        from mpi4py import MPI

        return self._reduce(values, MPI.MAX)

    def min(self, values):
        """Smallest over ranks of each number."""
        from mpi4py import MPI

        return self._reduce(values, MPI.MIN)

    def bcast(self, obj):
        """The object of rank 0."""
        return self.mpi.bcast(obj, root=0)

    def allgather(self, obj):
        """The list of every rank's object."""
        return self.mpi.allgather(obj)

    def gather(self, obj):
        """The list of every rank's object on rank 0, None on the others."""
        return self.mpi.gather(obj, root=0)

    def alltoall(self, objects):
        """The list of what every rank had for this one; objects: one for each rank."""
        return self.mpi.alltoall(objects)

    def counts(self, number):
        """Every rank's whole number, an array."""
        found = np.empty(self.size, np.int64)
        self.mpi.Allgather(np.array([number], np.int64), found)
        return found

    def share(self, values):
        """Rank 0's numbers, an array of float64; the others give as many."""
        values = np.array(values, dtype=np.float64)
        self.mpi.Bcast(values, root=0)
        return values

    def exchange(self, send, receive):
        """Messages between two ranks each: send[rank] goes to that rank, receive[rank] is filled from it; contiguous arrays."""
        from mpi4py import MPI

        requests = [self.mpi.Irecv(a, source=rank) for rank, a in receive.items()]
        requests += [self.mpi.Isend(a, dest=rank) for rank, a in send.items()]
        self.sent.add(sum(a.nbytes for a in send.values()), len(send))
        MPI.Request.Waitall(requests)

    def alltoall_bytes(self, send, receive):
        """send, receive: (array, bytes for or from each rank, their offsets)."""
        from mpi4py import MPI

        self.mpi.Alltoallv([send[0].view(np.uint8), *send[1:], MPI.BYTE], [receive[0].view(np.uint8), *receive[1:], MPI.BYTE])
        self.sent.add(sum(send[1]) - send[1][self.rank], np.count_nonzero(send[1]) - (send[1][self.rank] > 0))

    def pass_on(self, obj, ranks, source):
        """The object of rank `source`; ranks: those that want the object of this one."""
        requests = [self.mpi.isend(obj, dest=rank) for rank in ranks]
        found = self.mpi.recv(source=source)
        for request in requests:
            request.wait()
        return found

    def among(self, ranks):
        """The communicator of these ranks alone, rank 0 first; None on others. Made once: MPI has few of them. Collective."""
        from mpi4py import MPI

        ranks = tuple(map(int, ranks))
        if len(ranks) == self.size:
            return self
        if ranks not in self._among:
            mpi = self.mpi.Split(0 if self.rank in ranks else MPI.UNDEFINED, self.rank)
            made = None if mpi == MPI.COMM_NULL else SerialComm(self) if len(ranks) == 1 else MpiComm(mpi, self)
            self._among[ranks] = made
        return self._among[ranks]

    def barrier(self):
        """Wait for all ranks."""
        self.mpi.Barrier()


def launched():
    """Whether an MPI launcher started this process, and the number of processes if the launcher tells it (else None).

    The variable HPC_GFMD_LAUNCHER says "mpi" or "none" where that cannot be seen.
    """
    said = os.environ.get(LAUNCHER)
    if said == "none":
        return False, None
    size = next((int(os.environ[k]) for k in LAUNCHER_SIZE if os.environ.get(k, "").isdigit()), None)
    by_launcher = said == "mpi" or size is not None or any(k in os.environ for k in LAUNCHER_RANK)
    if by_launcher and size is None:
        size = _srun_size()  # PMIx tells processes their rank only
    return by_launcher, size


def _srun_size():
    """Number of processes that srun started with this one, or None."""
    text = os.environ.get("SLURM_STEP_NUM_TASKS", "")
    return int(text) if text.isdigit() else None


def launcher_rank():
    """This process's number as the launcher tells it; 0 without a launcher."""
    if os.environ.get(LAUNCHER) == "none":
        return 0
    return next((int(os.environ[k]) for k in (*LAUNCHER_RANK, "SLURM_PROCID") if os.environ.get(k, "").isdigit()), 0)


_world = None


def world():
    """The communicator of all processes of this run.

    Raises GfmdError when a launcher started several processes but mpi4py is missing: they would all do the same work; SceneError for
    a HPC_GFMD_LAUNCHER that means nothing.
    """
    global _world
    if _world is None:
        if os.environ.get(LAUNCHER, "") not in ("", "mpi", "none"):
            raise SceneError(f'{LAUNCHER}: found "{os.environ[LAUNCHER]}", allowed: "mpi", "none"')
        by_launcher, size = launched()
        if not by_launcher and (_srun_size() or 1) > 1 and not os.environ.get(LAUNCHER):
            raise GfmdError(f"srun started {_srun_size()} processes without MPI, allowed: srun --mpi=pmix, or mpirun (where each is "
                            f"to run on its own: {LAUNCHER}=none)")
        _world = SerialComm()
        if by_launcher and size != 1:
            try:
                from mpi4py import MPI
            except ImportError as error:
                raise GfmdError(
                    f"started by an MPI launcher{f' on {size} ranks' if size else ''}, but mpi4py cannot be imported "
                    f"({error}): install the extra 'mpi' or run without the launcher"
                ) from None
            if MPI.COMM_WORLD.Get_size() > 1:
                _world = MpiComm(MPI.COMM_WORLD)
                sys.excepthook = _abort_on_error(MPI.COMM_WORLD, sys.excepthook)
            elif size and size > 1:
                raise GfmdError(
                    f"the launcher started {size} processes but mpi4py sees one: "
                    f"mpi4py and mpirun belong to different MPI libraries"
                )
    return _world


def comm_of(given):
    """The communicator that a caller means: None for this process alone, one of mpi4py, or one of this file. Raises SceneError."""
    if given is None or isinstance(given, SerialComm | MpiComm):
        return given or SerialComm()
    if not hasattr(given, "Allreduce"):
        raise SceneError(f"comm: found {type(given).__name__}, allowed: a communicator of mpi4py, such as MPI.COMM_WORLD")
    return MpiComm(given) if given.Get_size() > 1 else SerialComm()


def threads_of(comm, wanted):
    """Threads for each rank: a number as it is; "auto": what Slurm was asked for (--cpus-per-task), else the cores that this rank may
    use, shared with the ranks beside it.

    Raises SceneError on all ranks for more than some machine can bear: every thread takes memory of its own. Collective.
    """
    if wanted != "auto":
        wanted = int(wanted)
        most = int(comm.min([THREADS_PER_CORE * (os.cpu_count() or 1)])[0])
        if wanted > most:
            raise SceneError(f"machine.threads: found {wanted}, allowed on this machine: up to {most} ({THREADS_PER_CORE} per core)")
        return wanted
    cores = sorted(os.sched_getaffinity(0))
    of_slurm = os.environ.get("SLURM_CPUS_PER_TASK", "")
    if comm.min([of_slurm.isdigit() and int(of_slurm)])[0] > 0:
        return min(int(of_slurm), len(cores))
    here = comm.allgather((os.uname().nodename, cores))
    beside = sum(other == here[comm.rank] for other in here)  # ranks that are bound elsewhere do not share our cores
    return max(1, len(cores) // beside)


def leave_together(exit_code, seconds=10.0, say=None):
    """Wait until all ranks are about to leave with an error: mpirun ends the others, silently, as soon as one has left.

    Not for ever: a rank that is alone with its error ends the job after `seconds`. say(): rank 0 calls it at once, another rank
    where it is left alone, so that it is heard once.
    """
    say = say or (lambda: None)
    if launcher_rank() == 0:
        say()
    try:
        comm = world()
    except GfmdError:  # no way to wait for each other: time enough for one line
        time.sleep(1.0 if launched()[0] else 0.0)
        return
    if comm.size > 1:
        request, end = comm.mpi.Ibarrier(), time.monotonic() + seconds
        while not request.Test():
            if time.monotonic() > end:
                if comm.rank != 0:
                    say()
                comm.mpi.Abort(exit_code)
            time.sleep(0.01)


def _abort_on_error(mpi, hook):
    """An exception that nobody caught on one rank ends all ranks: the others would wait for it forever."""

    def excepthook(kind, value, traceback):
        hook(kind, value, traceback)
        unfailing(sys.stderr).flush()
        mpi.Abort(1)

    return excepthook


def agree(comm, error):
    """Raise on every rank if any rank has an error (an exception or None): the first one's, as the same type."""
    if comm.size == 1:
        if error is not None:
            raise error
        return
    if not comm.max([error is not None])[0]:
        return
    failed = comm.allgather(None if error is None else (type(error), str(error)))
    kind, text = next(f for f in failed if f is not None)
    raise error if error is not None else (kind(text) if issubclass(kind, GfmdError) else GfmdError(text))
