"""The communicator of a run: of all processes that a launcher started, or what a caller gives."""

import os
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from types import TracebackType
from typing import Any

from ..util.errors import GfmdError, SceneError, how_to_install, one_line
from .comm import Comm, MpiComm, SerialComm
from .launcher import LAUNCHER, enclosing_mpi_program, launched, launcher_rank, srun_size

REBUILD = "pip install --force-reinstall --no-deps --no-cache-dir --no-binary=mpi4py mpi4py"

Hook = Callable[[type[BaseException], BaseException, TracebackType | None], Any]

_world: Comm | None = None


def world() -> Comm:
    """Return the communicator of all processes of this run, made at the first call.

    The first call may start MPI; with several ranks it also sets sys.excepthook, so that an
    uncaught exception of one rank ends them all.

    Returns
    -------
    Comm
        Of all processes that an MPI launcher started, or of this one alone.

    Raises
    ------
    GfmdError
        If a launcher started several processes that cannot communicate: they would all do the same
        work.
    SceneError
        If HPC_GFMD_LAUNCHER has a value that is not allowed.
    """
    global _world
    if _world is None:
        _world = _launched_world()
    return _world


def _launched_world() -> Comm:
    """Make the communicator that `world` returns: that of mpi4py under a launcher."""
    setting = os.environ.get(LAUNCHER, "")
    if setting not in ("", "mpi", "none"):
        raise SceneError(f'{LAUNCHER}: found "{setting}", allowed: "mpi", "none"')
    by_launcher, size = launched()
    if not by_launcher and (srun_size() or 1) > 1 and not setting:
        raise GfmdError(
            f"srun started {srun_size()} processes without MPI, allowed: srun --mpi=pmix, or"
            f" mpirun (where each is to run on its own: {LAUNCHER}=none)"
        )
    if not by_launcher or size == 1:
        return SerialComm()
    if program := enclosing_mpi_program():
        raise GfmdError(
            f"started by a rank of another MPI program ({one_line(program, 80)}), inside which MPI"
            f" does not start again: call hpc_gfmd.run(scene, comm=...) there, or set"
            f" {LAUNCHER}=none for a run of one process"
        )
    try:
        MPI = load_mpi()
    except GfmdError as error:
        ranks = f" on {size} ranks" if size else ""
        raise GfmdError(
            f"started by an MPI launcher{ranks}, but {error}; or run without the launcher"
        ) from None
    if MPI.COMM_WORLD.Get_size() > 1:
        sys.excepthook = _abort_on_error(MPI.COMM_WORLD, sys.excepthook)
        return MpiComm(MPI.COMM_WORLD)
    if size is not None:
        raise GfmdError(
            f"the launcher started {size} processes but mpi4py sees one: mpi4py was built for"
            f" {MPI.get_vendor()[0]}, mpirun belongs to another MPI library: load the modules of"
            f" the installation, or build it for this one: {REBUILD}"
        )
    return SerialComm()


def load_mpi() -> Any:
    """Import mpi4py.MPI, which starts MPI; GfmdError if it is missing or finds another library."""
    try:
        import mpi4py
    except ImportError as error:
        raise GfmdError(
            f"mpi4py cannot be imported ({one_line(str(error))}): {how_to_install('mpi4py')}"
        ) from None
    try:
        from mpi4py import MPI
    except (ImportError, RuntimeError) as error:  # RuntimeError: of its wheels
        reason = one_line(str(error).partition("\n")[0])
        raise GfmdError(
            f"mpi4py {mpi4py.__version__} is installed but does not load an MPI library"
            f" ({reason}); it has to be built for the one that is here: {REBUILD}"
        ) from None
    return MPI


def collective_exit(
    exit_code: int, seconds: float = 10.0, say: Callable[[], object] | None = None
) -> None:
    """Wait until all ranks are about to leave with an error: mpirun kills others silently once one
    leaves. Rank 0 calls `say` at once; another one only if alone for `seconds`, and then aborts the
    job.
    """
    say = say or (lambda: None)
    if launcher_rank() == 0:
        say()
    try:
        comm = world()
    except GfmdError:  # no way to wait for each other: time enough for one line
        time.sleep(1.0 if launched()[0] else 0.0)
        return
    if not comm.wait_asleep(seconds):
        if comm.rank != 0:
            say()
        comm.mpi.Abort(exit_code)


def comm_of(argument: Any) -> Comm:
    """Return the Comm of an mpi4py communicator, a Comm as it is, or None: this process alone."""
    if argument is None or isinstance(argument, SerialComm | MpiComm):
        return argument or SerialComm()
    if not hasattr(argument, "Allreduce"):
        raise SceneError(
            f"comm: found {type(argument).__name__}, allowed: a communicator of mpi4py, such as"
            " MPI.COMM_WORLD"
        )
    return MpiComm(argument) if argument.Get_size() > 1 else SerialComm()


def _abort_on_error(mpi: Any, hook: Hook) -> Hook:
    """Return an excepthook that calls `hook` and ends all ranks, which else wait for ever."""

    def excepthook(
        kind: type[BaseException], value: BaseException, traceback: TracebackType | None
    ) -> None:
        hook(kind, value, traceback)
        with suppress(OSError, ValueError, AttributeError):  # it may be closed
            sys.stderr.flush()
        mpi.Abort(1)

    return excepthook
