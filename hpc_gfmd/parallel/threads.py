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
SMALLEST_SHARE = 32  # of a compiled pass: a thread's equal part over this


def piece_rows(n_y: int) -> int:
    """Return how many rows of n_y points make a piece, which a thread works on at a time."""
    return max(PIECE_ROWS, PIECE_POINTS // n_y)


def pieces_of(rows: int, n_y: int) -> list[tuple[int, int]]:
    """Cut rows into pieces of nearly the same size, which a thread works on at a time.

    Parameters
    ----------
    rows : int
        Their number.
    n_y : int
        Points of each.

    Returns
    -------
    list of (int, int)
        (start, stop) of each piece, in order. They do not depend on the number of threads.
    """
    count = max(1, rows // piece_rows(n_y))
    ends = [rows * k // count for k in range(count + 1)]
    return [(i0, i1) for i0, i1 in zip(ends, ends[1:]) if i0 < i1]


def threads_for(points: int, threads: int) -> int:
    """Return how many of some threads get a piece of a grid; more would have nothing to do.

    Parameters
    ----------
    points : int
        Of the grid.
    threads : int
        Number of threads.

    Returns
    -------
    int
        From 1 to `threads`.
    """
    return max(1, min(threads, points // PIECE_POINTS))


def shares(count: int, threads: int) -> list[tuple[int, int]]:
    """Cut range(count) into parts, each for one compiled call on a thread.

    On several threads large parts come first and small ones last: a thread that begins late, or is
    slower than the others, leaves them little to wait for.

    Parameters
    ----------
    count : int
        Length of the range.
    threads : int
        Number of threads that share it.

    Returns
    -------
    list of (int, int)
        (start, stop) of each part, in order.
    """
    smallest = max(1, count // (SMALLEST_SHARE * threads))
    ends = [0]
    while ends[-1] < count:
        rest = count - ends[-1]
        share = max(smallest, rest // (2 * threads)) if threads > 1 else rest
        ends.append(ends[-1] + min(share, rest))
    return list(zip(ends, ends[1:]))


def on_threads(
    threads: int,
    work: Callable[..., T],
    pieces: Iterable[tuple],
    scratch: Sequence[Any] | None = None,
) -> list[T]:
    """Call work(*piece) for every piece, on whichever thread is free, and wait for all of them.

    Threads run at the same time only while `work` has left Python: in kernels, transforms and
    NumPy. An exception of `work` is raised once all threads have ended.

    Parameters
    ----------
    threads : int
        Number of threads, this one among them.
    work : function
        What is called.
    pieces : iterable of tuple
        Its arguments.
    scratch : sequence, optional
        One more, last argument for each thread: scratch[thread].

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
