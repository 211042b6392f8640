"""The communicator of a run: of all processes that a launcher started, or what a caller gives; and
the threads of each rank."""

import os
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from types import TracebackType
from typing import Any

from ..util.errors import GfmdError, SceneError
from ..util.machine import cores
from .comm import Comm, MpiComm, SerialComm
from .launcher import LAUNCHER, launched, launcher_rank, number_in, srun_size, tasks_per_node

THREADS_PER_CORE = 8  # more are a mistake
THREADED_POINTS = 2**20  # of a surface; two threads take as long as one for a quarter of them
Hook = Callable[[type[BaseException], BaseException, TracebackType | None], Any]

_world: Comm | None = None


def world() -> Comm:
    """Return the communicator of all processes of this run.

    Raises GfmdError when a launcher started several processes but mpi4py is missing: they would all
    do the same work; SceneError for a HPC_GFMD_LAUNCHER that means nothing.
    """
    global _world
    if _world is None:
        if os.environ.get(LAUNCHER, "") not in ("", "mpi", "none"):
            raise SceneError(f'{LAUNCHER}: found "{os.environ[LAUNCHER]}", allowed: "mpi", "none"')
        by_launcher, size = launched()
        if not by_launcher and (srun_size() or 1) > 1 and not os.environ.get(LAUNCHER):
            raise GfmdError(
                f"srun started {srun_size()} processes without MPI, allowed: srun --mpi=pmix, or"
                f" mpirun (where each is to run on its own: {LAUNCHER}=none)"
            )
        _world = SerialComm()
        if by_launcher and size != 1:
            try:
                from mpi4py import MPI
            except ImportError as error:
                raise GfmdError(
                    f"started by an MPI launcher{f' on {size} ranks' if size else ''}, but mpi4py"
                    f" cannot be imported ({error}): install the extra 'mpi' or run without the"
                    " launcher"
                ) from None
            if MPI.COMM_WORLD.Get_size() > 1:
                _world = MpiComm(MPI.COMM_WORLD)
                sys.excepthook = _abort_on_error(MPI.COMM_WORLD, sys.excepthook)
            elif size and size > 1:
                raise GfmdError(
                    f"the launcher started {size} processes but mpi4py sees one: mpi4py and mpirun"
                    " belong to different MPI libraries"
                )
    return _world


def collective_exit(
    exit_code: int, seconds: float = 10.0, say: Callable[[], object] | None = None
) -> None:
    """Wait until all ranks are about to leave with an error: mpirun ends the others, silently, as
    soon as one has left.

    Not for ever: a rank that is alone with its error ends the job after `seconds`. say(): rank 0
    calls it at once, another rank where it is left alone, so that it is heard once.
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


def comm_of(given: Any) -> Comm:
    """Return the communicator that a caller means: None for this process alone, one of mpi4py, or
    one of comm.py. Raises SceneError."""
    if given is None or isinstance(given, SerialComm | MpiComm):
        return given or SerialComm()
    if not hasattr(given, "Allreduce"):
        raise SceneError(
            f"comm: found {type(given).__name__}, allowed: a communicator of mpi4py, such as"
            " MPI.COMM_WORLD"
        )
    return MpiComm(given) if given.Get_size() > 1 else SerialComm()


def threads_of(comm: Comm, wanted: int | str, points: int) -> int:
    """Choose the threads for each rank: a number as it is; "auto": what Slurm was asked for
    (--cpus-per-task), else as `auto_threads`; points: of the surface.

    Raises SceneError on all ranks for more than some machine can bear: every thread takes memory of
    its own. Collective.
    """
    if wanted != "auto":
        wanted = int(wanted)
        most = int(comm.min([THREADS_PER_CORE * (os.cpu_count() or 1)])[0])
        if wanted > most:
            raise SceneError(
                f"machine.threads: found {wanted}, allowed on this machine: up to {most}"
                f" ({THREADS_PER_CORE} per core)"
            )
        return wanted
    here = len(cores())
    asked = int(comm.min([number_in("SLURM_CPUS_PER_TASK") or 0])[0])
    return min(asked, here) or auto_threads(points, comm.size, here)


def auto_threads(points: int, ranks: int, cores: int) -> int:
    """Choose the threads for each rank where nobody says how many: one of several ranks; all cores
    for one process, or one where the points are so few that more do not pay."""
    return cores if ranks == 1 and points >= THREADED_POINTS else 1


def ranks_per_node(ranks: int, threads: int) -> int:
    """Tell how many of so many ranks share a node, as long as nobody says: as many as Slurm starts
    on one, else as the cores that this process may use are enough for."""
    return min(ranks, tasks_per_node() or max(1, len(cores()) // threads))


def _abort_on_error(mpi: Any, hook: Hook) -> Hook:
    """Make an excepthook by which an exception that nobody caught on one rank ends all ranks: the
    others would wait for it forever."""

    def excepthook(
        kind: type[BaseException], value: BaseException, traceback: TracebackType | None
    ) -> None:
        hook(kind, value, traceback)
        with suppress(OSError, ValueError, AttributeError):  # it may be closed
            sys.stderr.flush()
        mpi.Abort(1)

    return excepthook
