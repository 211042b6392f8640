"""Leaving with an error, all ranks together."""

import time
from collections.abc import Callable

from ..util.errors import GfmdError
from .launcher import launched, launcher_rank
from .world import world


def leave_together(
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
