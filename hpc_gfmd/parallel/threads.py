"""Work on all threads of a rank: the one way in which a pass over a field is shared out.

What is worked on comes in pieces that do not depend on the number of threads, and results come in
the order of the pieces: so no number does either.
"""

import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from functools import cache
from typing import Any, TypeVar

import numpy as np

T = TypeVar("T")

PIECE_POINTS = 2**17  # of a field, which a thread works on at a time
PIECE_ROWS = 8  # at least
SHARES = 4  # of a compiled pass that each thread does


def piece_rows(n_y: int) -> int:
    """Return how many rows of n_y points a thread works on at a time."""
    return max(PIECE_ROWS, PIECE_POINTS // n_y)


def threads_for(points: int, threads: int) -> int:
    """Return how many threads pay: those that get a piece.

    Parameters
    ----------
    points : int
        Of the grid.
    threads : int
        That there are.

    Returns
    -------
    int
        At least 1.
    """
    return max(1, min(threads, points // PIECE_POINTS))


def shares(count: int, threads: int) -> list[tuple[int, int]]:
    """Cut a range into what a thread does in one compiled call.

    On several threads that is several times each, because none of them is always as fast as the
    others.

    Parameters
    ----------
    count : int
        Length of the range.
    threads : int
        That share it.

    Returns
    -------
    list of (int, int)
        (start, stop) of each part, in order.
    """
    parts = max(1, min(count, SHARES * threads if threads > 1 else 1))
    ends = [count * part // parts for part in range(parts + 1)]
    return list(zip(ends, ends[1:]))


def on_threads(
    threads: int,
    work: Callable[..., T],
    pieces: Iterable[tuple],
    scratch: Sequence[Any] | None = None,
) -> list[T]:
    """Call work(*piece) for every piece, on whichever thread is free.

    Threads run at the same time only where `work` leaves Python: in kernels, transforms and NumPy.

    Parameters
    ----------
    threads : int
        Number of threads, this one among them.
    work : function
        What is called.
    pieces : iterable of tuple
        Its arguments.
    scratch : sequence, optional
        One more argument, of each thread its own.

    Returns
    -------
    list
        What work returned, in the order of the pieces.
    """
    pieces = list(pieces)
    results: list[Any] = [None] * len(pieces)
    remaining = iter(enumerate(pieces))  # a thread takes the next one in one step

    def work_on(thread: int) -> None:
        scratch_of_thread = [] if scratch is None else [scratch[thread]]
        for k, piece in remaining:
            results[k] = work(*piece, *scratch_of_thread)

    futures = [_pool().submit(work_on, thread) for thread in range(1, min(threads, len(pieces)))]
    try:
        work_on(0)
    finally:
        if futures:  # asking takes longer than a coarse grid
            wait(futures)
    for future in futures:
        future.result()
    return results


def added(parts: Sequence[Sequence[float]], count: int) -> np.ndarray:
    """Add up the numbers that every piece of work returned.

    Parameters
    ----------
    parts : sequence of sequence of float
        What each piece returned; there may be no piece.
    count : int
        How many numbers each returned.

    Returns
    -------
    ndarray, shape (count,)
        The sums.
    """
    return np.sum(np.reshape(parts, (-1, count)), axis=0)


@cache
def _pool() -> ThreadPoolExecutor:
    """Make the threads of this process, as they are needed."""
    return ThreadPoolExecutor(2**16, "hpc-gfmd")


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_pool.cache_clear)  # its threads are not forked
