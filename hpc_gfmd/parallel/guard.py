"""Blocks of work that fail on all ranks or on none: a rank that raises while others wait hangs the
job."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeVar

from ..util.errors import GfmdError, reason
from .comm import Comm

T = TypeVar("T")


@contextmanager
def collective_errors(comm: Comm, doing: str) -> Iterator[None]:
    """Make a block raise on every rank if it raises on any. Collective.

    The block must not contain a collective call that a failing rank would skip, unless that call is
    in such a block of its own. A GfmdError stays what it is, any other Exception becomes one whose
    message begins with `doing`; a rank that has not failed gets that of the lowest rank that has. A
    KeyboardInterrupt or SystemExit leaves the block on its rank alone, while the others wait.
    """
    error: GfmdError | None = None
    try:
        yield
    except GfmdError as caught:
        error = caught
    except Exception as caught:
        error = GfmdError(f"{doing}: {reason(caught)}")
        error.__cause__ = caught
    raise_on_all(comm, error)


def on_rank_0(comm: Comm, doing: str, work: Callable[[], T]) -> T:
    """Call a function on rank 0 alone, and return its result on every rank. Collective.

    Parameters
    ----------
    comm : Comm
        All ranks.
    doing : str
        Beginning of an error's message: "writing contact.h5".
    work : function
        Takes no arguments; returns what can be pickled.

    Returns
    -------
    object
        What work() returned, on all ranks.

    Raises
    ------
    GfmdError
        On every rank if work raises, as `collective_errors` does.
    """
    result = None
    with collective_errors(comm, doing):
        if comm.rank == 0:
            result = work()
    return comm.bcast(result)


def raise_on_all(comm: Comm, error: Exception | None) -> None:
    """Raise on every rank if any rank has an error; return if none has one. Collective.

    A rank raises its own error, others that of the lowest rank: with its type and text if it is a
    GfmdError, otherwise a GfmdError. Ranks wait for each other asleep: one of them may be busy for
    a long time, on their cores.
    """
    comm.wait_asleep()
    failing_rank = int(comm.min([comm.size if error is None else comm.rank])[0])
    if failing_rank == comm.size:
        return
    kind, text = comm.bcast(None if error is None else (type(error), str(error)), failing_rank)
    if error is not None:
        raise error
    raise kind(text) if issubclass(kind, GfmdError) else GfmdError(text)
