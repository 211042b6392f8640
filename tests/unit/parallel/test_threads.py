"""Work that is shared out among threads: order, errors, threads within threads, forks."""

import os
import threading
import time

import pytest

from hpc_gfmd.parallel.threads import PIECE_ROWS, on_threads, pieces_of


def together(threads, count):
    """Numbers of the threads that do so many pieces, none of which ends before all have begun."""
    meeting = threading.Barrier(threads, timeout=30)

    def work(k):
        meeting.wait()
        return k, threading.get_ident()

    results = on_threads(threads, work, [(k,) for k in range(count)])
    assert [k for k, _ in results] == list(range(count))
    return {thread for _, thread in results}


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_all_threads_work(threads):
    """This thread is one of them, and the same ones work again."""
    first = together(threads, threads)
    assert threading.get_ident() in first
    assert len(first) == threads
    count = threading.active_count()
    together(threads, 3 * threads)
    assert threading.active_count() == count


def test_each_thread_has_its_scratch():
    """No two threads have the same at once."""
    used = []

    def work(k, scratch):
        used.append(scratch)
        assert used.count(scratch) == 1
        time.sleep(1e-3)
        used.remove(scratch)

    on_threads(3, work, [(k,) for k in range(30)], "abc")


@pytest.mark.parametrize("where", ["this thread", "another thread"])
def test_an_error_comes_back_when_all_have_ended(where):
    here = threading.get_ident()
    meeting = threading.Barrier(2, timeout=30)
    ended = []

    def work(k):
        meeting.wait()
        if (threading.get_ident() == here) == (where == "this thread"):
            raise ValueError(where)
        time.sleep(0.05)
        ended.append(k)

    with pytest.raises(ValueError, match=where):
        on_threads(2, work, [(0,), (1,)])
    assert len(ended) == 1
    together(2, 2)  # the threads are as good as before


def test_threads_within_threads():
    results = on_threads(3, lambda k: together(2, 2), [(k,) for k in range(6)])
    assert all(len(threads) == 2 for threads in results)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
@pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")
def test_a_fork_has_threads_of_its_own():
    together(2, 2)
    child = os.fork()
    if child == 0:
        threads = 0
        try:
            threads = len(together(2, 2))
        finally:
            os._exit(threads)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 2


@pytest.mark.parametrize("rows", [1, 7, 8, 9, 31, 64, 100, 2048])
@pytest.mark.parametrize("n_y", [64, 2048, 2**15, 2**17])
def test_pieces_of_rows(rows, n_y):
    """They cover all rows in order; none is so short that its neighbours' halos overlap."""
    pieces = pieces_of(rows, n_y)
    assert pieces[0][0] == 0
    assert pieces[-1][1] == rows
    assert all(stop == start for (_, stop), (start, _) in zip(pieces, pieces[1:]))
    assert all(stop - start >= min(PIECE_ROWS, rows) for start, stop in pieces)
