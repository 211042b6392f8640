"""Work on all threads of a rank: the one way in which a pass over a field is shared out.

What is worked on comes in pieces that do not depend on the number of threads, and results come in
the order of the pieces: so no number does either.
"""

import os
import threading
from collections.abc import Callable, Iterable, Sequence
from functools import partial
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
    """Return how many threads are useful for a grid: each of them must get a piece.

    Parameters
    ----------
    points : int
        Of the grid.
    threads : int
        Number of threads that there are.

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

    helpers: list[_Helper] = []
    try:
        for thread in range(1, min(threads, len(pieces))):
            helpers.append(_free_helper())
            helpers[-1].begin(partial(work_on, thread))
        work_on(0)
    finally:
        for helper in helpers:
            helper.wait()
    errors = [helper.error for helper in helpers if helper.error is not None]
    _free_helpers.extend(helpers)
    if errors:
        raise errors[0]
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


class _Helper:
    """A thread that waits for work, does it, and waits again, until the process ends.

    Two locks take a third of the time of an executor's queue and futures.
    """

    def __init__(self) -> None:
        self.error: BaseException | None = None
        self._work: Callable[[], None] | None = None
        self._begun = threading.Lock()
        self._ended = threading.Lock()
        self._begun.acquire()
        self._ended.acquire()
        threading.Thread(target=self._run, name="hpc-gfmd", daemon=True).start()

    def begin(self, work: Callable[[], None]) -> None:
        """Have the thread call work(), and return at once; `wait` before the next `begin`."""
        self.error = None
        self._work = work
        self._begun.release()

    def wait(self) -> None:
        """Wait until the work has ended; `error` is then the exception that it raised, or None."""
        self._ended.acquire()

    def _run(self) -> None:
        """Do in the thread whatever `begin` asks for, forever."""
        while True:
            self._begun.acquire()
            try:
                if self._work is not None:
                    self._work()
            except BaseException as error:
                self.error = error
            self._work = None  # it refers to fields
            self._ended.release()


_free_helpers: list[_Helper] = []  # of this process; whoever needs one takes it out


def _free_helper() -> _Helper:
    """Take a helper that has no work out of `_free_helpers`, or make a new one."""
    try:
        return _free_helpers.pop()
    except IndexError:
        return _Helper()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_free_helpers.clear)  # threads are not forked
