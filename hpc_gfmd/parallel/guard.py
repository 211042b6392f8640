"""Blocks of work that fail on all ranks or on none: a rank that raises alone hangs the others."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeVar

from ..util.errors import GfmdError, reason
from .comm import Comm

T = TypeVar("T")


@contextmanager
def collective_errors(comm: Comm, doing: str) -> Iterator[None]:
    """Make a block raise on every rank if it raises on any. Collective.

    The block must not contain a collective call that a failing rank would skip, unless in such a
    block of its own. A GfmdError stays, other Exceptions become one that begins with `doing`; ranks
    that have not failed raise that of the lowest that has. KeyboardInterrupt and SystemExit are not
    passed on.
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
    """Raise on every rank if any rank has an error: its own, or that of the lowest rank, as
    GfmdError. Collective; ranks wait asleep, as another may need their cores for long.
    """
    comm.wait_asleep()
    failing_rank = int(comm.min([comm.size if error is None else comm.rank])[0])
    if failing_rank == comm.size:
        return
    kind, text = comm.bcast(None if error is None else (type(error), str(error)), failing_rank)
    if error is not None:
        raise error
    raise kind(text) if issubclass(kind, GfmdError) else GfmdError(text)
