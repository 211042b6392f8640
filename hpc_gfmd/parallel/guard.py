"""Blocks of work that fail on all ranks or on none: a rank that raises alone hangs the others."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from traceback import format_exception
from typing import TypeVar

from ..util.errors import GfmdError, ProgrammingError, is_mistake, reason
from .comm import Comm

T = TypeVar("T")


@contextmanager
def collective_errors(comm: Comm, doing: str) -> Iterator[None]:
    """Make a block raise on every rank if it raises on any. Collective.

    The block must not contain a collective call that a failing rank would skip, unless in such a
    block of its own. A GfmdError and a programming error stay, other Exceptions become a GfmdError
    that begins with `doing`; ranks that have not failed raise that of the lowest that has.
    KeyboardInterrupt and SystemExit are not passed on.
    """
    error: Exception | None = None
    try:
        yield
    except Exception as caught:
        error = caught
        if not (isinstance(caught, GfmdError) or is_mistake(caught)):
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
        On every rank if work raises, with the reason of any error but a programming error, which
        is raised itself, on other ranks as ProgrammingError.
    """
    result = None
    with collective_errors(comm, doing):
        if comm.rank == 0:
            result = work()
    return comm.bcast(result)


def raise_on_all(comm: Comm, error: Exception | None) -> None:
    """Raise on every rank if any has an error: its own, or that of the lowest rank, as a GfmdError
    or as a ProgrammingError with its traceback. Collective; ranks wait asleep, as another may need
    their cores for long.
    """
    comm.wait_asleep()
    failing_rank = int(comm.min([comm.size if error is None else comm.rank])[0])
    if failing_rank == comm.size:
        return
    is_foreseen = error is None or isinstance(error, GfmdError)
    text = str(error) if is_foreseen else "".join(format_exception(error))
    kind, text = comm.bcast((type(error), text), failing_rank)
    if error is not None:
        raise error
    if issubclass(kind, GfmdError):
        raise kind(text)
    raise ProgrammingError(f"{kind.__name__} on rank {failing_rank}\n{text}")
