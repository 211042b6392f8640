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
    """Collective block: when any rank fails inside it, every rank leaves it with an error.

    `doing` starts the message ("writing contact.h5"). The block itself must hold no collective call
    that a failing rank would skip, unless in a block of this kind of its own. A GfmdError stays
    what it is, anything else becomes one.
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
    """Call a function on rank 0 alone; every rank gets what it returns, or its error. Collective.

    Parameters
    ----------
    comm
        A communicator, as `world` gives it.
    doing : str
        What the message of an error begins with: "writing contact.h5".
    work : function
        Takes no arguments.

    Returns
    -------
    object
        What work() returns, broadcast.

    Raises
    ------
    GfmdError
        On every rank, as `collective_errors` does.
    """
    found = None
    with collective_errors(comm, doing):
        if comm.rank == 0:
            found = work()
    return comm.bcast(found)


def raise_on_all(comm: Comm, error: Exception | None) -> None:
    """Raise on every rank if any rank has an error (an exception or None): the first one's, as the
    same type."""
    first = int(comm.min([comm.size if error is None else comm.rank])[0])
    if first == comm.size:
        return
    kind, text = comm.bcast(None if error is None else (type(error), str(error)), first)
    if error is not None:
        raise error
    raise kind(text) if issubclass(kind, GfmdError) else GfmdError(text)
