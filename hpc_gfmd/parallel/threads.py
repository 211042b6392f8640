"""Work on all threads of a rank; pieces and the order of results do not depend on the number of
threads, and so no number does.
"""

import os
import threading
from collections.abc import Callable, Iterable, Sequence
from functools import lru_cache, partial
from typing import Any, TypeVar

import numpy as np

T = TypeVar("T")

PIECE_POINTS = 2**17  # of a field, which a thread works on at a time
PIECE_ROWS = 8  # at least
HALVINGS = 2  # of the last piece: the less is left at the end, the less threads wait for each other
THREAD_POINTS = 2**15  # of a grid, for each of its threads: fewer take less time than a hand-over


def piece_rows(n_y: int) -> int:
    """Return how many rows of n_y points make a piece, which a thread works on at a time."""
    return max(PIECE_ROWS, PIECE_POINTS // n_y)


@lru_cache(maxsize=256)
def pieces_of(rows: int, n_y: int) -> tuple[tuple[int, int], ...]:
    """Cut rows of n_y points into nearly equal pieces of at least PIECE_ROWS, the last cut finer;
    independent of the number of threads.
    """
    count = max(1, rows // piece_rows(n_y))
    ends = [rows * k // count for k in range(count)]
    for _ in range(HALVINGS if count > 1 else 0):
        middle = (ends[-1] + rows) // 2
        if middle - ends[-1] >= PIECE_ROWS:
            ends.append(middle)
    ends.append(rows)
    return tuple((i0, i1) for i0, i1 in zip(ends, ends[1:]) if i0 < i1)


def threads_for(points: int, threads: int, points_each: int = THREAD_POINTS) -> int:
    """Return how many of the threads are useful: each must get `points_each` points."""
    return max(1, min(threads, points // points_each))


def shares(count: int, threads: int) -> list[tuple[int, int]]:
    """Cut range(count) into parts for compiled calls: large ones first, small ones last, so that a
    thread that begins late is not waited for.
    """
    ends = [0]
    while ends[-1] < count:
        rest = count - ends[-1]
        share = max(1, rest // (2 * threads)) if threads > 1 else rest
        ends.append(ends[-1] + share)
    return list(zip(ends, ends[1:]))


class Shares:
    """A range in `parts` (parts, 2) that threads take by themselves in compiled calls, for one
    pass; `turns` is the next one (kernels/atomic.py: add).
    """

    def __init__(self, count: int, threads: int):
        self.parts = _parts(count, threads)
        self.turns = np.zeros(1, np.int64)
        self._threads = min(threads, len(self.parts))

    def on_threads(self, work: Callable[[Any], Any], scratch: Sequence[Any]) -> None:
        """Call work(scratch[thread]) on threads at once; they take parts by `turns` until all are
        done.
        """
        on_threads(self._threads, work, [()] * self._threads, scratch)


@lru_cache(maxsize=256)
def _parts(count: int, threads: int) -> np.ndarray:
    """Return `shares` as an array (parts, 2), which must not be written to."""
    return np.array(shares(count, threads), np.int64).reshape(-1, 2)


def on_threads(
    threads: int,
    work: Callable[..., T],
    pieces: Iterable[tuple],
    scratch: Sequence[Any] | None = None,
) -> list[T]:
    """Call work(*piece), or work(*piece, scratch[thread]), on whichever thread is free; return
    results in order. Parallel only while outside Python; an exception is raised once all threads
    have ended.
    """
    pieces = list(pieces)
    if threads == 1 or len(pieces) == 1:  # of small grids what follows takes longer than the work
        own_scratch = [] if scratch is None else [scratch[0]]
        return [work(*piece, *own_scratch) for piece in pieces]
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
            helper.end()
    errors = [helper.error for helper in helpers if helper.error is not None]
    _free_helpers.extend(helpers)
    if errors:
        raise errors[0]
    return results


def added(parts: Sequence[Sequence[float]], count: int) -> np.ndarray:
    """Add up the `count` numbers that each piece of work returned; there may be no piece."""
    return np.sum(np.reshape(parts, (-1, count)), axis=0)


class _Helper:
    """A thread for one piece of work after another, in a third of the time of an executor."""

    def __init__(self) -> None:
        self.error: BaseException | None = None
        self._work: list[Callable[[], None]] = []  # at most one; whoever takes it out has it
        self._has_begun = False
        self._begun = threading.Lock()
        self._ended = threading.Lock()
        self._begun.acquire()
        self._ended.acquire()
        threading.Thread(target=self._run, name="hpc-gfmd", daemon=True).start()

    def begin(self, work: Callable[[], None]) -> None:
        """Let the thread do some work; `end` must have been called for the work before."""
        self.error = None
        self._work.append(work)
        self._has_begun = True
        if self._begun.locked():  # if not, it has yet to wake up for work that was withdrawn
            self._begun.release()

    def end(self) -> None:
        """Wait for the work, or withdraw it if the thread still sleeps; its error is in `error`."""
        try:
            self._work.pop()
        except IndexError:
            if self._has_begun:
                self._ended.acquire()
        self._has_begun = False

    def _run(self) -> None:
        while True:
            self._begun.acquire()
            try:
                work = self._work.pop()
            except IndexError:
                continue
            try:
                work()
            except BaseException as error:
                self.error = error
            del work  # it refers to fields
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
