"""Rows that windows of several ranks share: every rank gets what all of them have, added up."""

import threading

import numpy as np
import pytest

from hpc_gfmd.parallel.halo import Overlaps, add_all, add_overlaps


class Threads:
    """Ranks that are threads of this process, as add_overlaps takes a communicator."""

    def __init__(self, size):
        self.size = size
        self.box = {}
        self.barrier = threading.Barrier(size, timeout=10)

    def of_rank(self, rank):
        one = Threads.__new__(Threads)
        one.__dict__ |= self.__dict__
        one.rank = rank
        return one

    def allgather_arrays(self, send, receive, counts):
        self.box[self.rank] = send
        self.barrier.wait()
        receive[...] = np.concatenate([self.box[rank] for rank in range(len(counts))])

    def exchange(self, send, receive):
        self.box.update({(self.rank, peer): values for peer, values in send.items()})
        self.barrier.wait()
        for peer, values in receive.items():
            values[...] = self.box[peer, self.rank]
        self.barrier.wait()


def windows_of(random, n, ranks):
    """lo and hi of all ranks: rows cut anywhere, one more before and up to two more after."""
    cuts = np.array([0, *np.sort(random.integers(0, n + 1, ranks - 1)), n])
    has_rows = np.diff(cuts) > 0
    lo = cuts[:-1] - has_rows * random.integers(0, 2, ranks)
    return lo, np.where(has_rows, cuts[1:] + random.integers(0, 3, ranks), lo)


with_rings = pytest.mark.parametrize(
    ("n", "ranks"), [(1, 1), (2, 1), (5, 1), (5, 2), (8, 4), (17, 4), (3, 4), (40, 7)]
)


def on_all_ranks(work, ranks):
    """Call work(communicator of the rank, rank) at the same time on all ranks."""
    world = Threads(ranks)
    at_work = [
        threading.Thread(target=work, args=(world.of_rank(rank), rank)) for rank in range(ranks)
    ]
    for thread in at_work:
        thread.start()
    for thread in at_work:
        thread.join()


def sums_of(n, lo, hi, windows):
    """What all windows have of each row of the ring."""
    sums = np.zeros((2, n, 3))
    for begin, end, window in zip(lo, hi, windows, strict=True):
        for k, row in enumerate(range(begin, end)):
            sums[:, row % n] += window[:, k]
    return sums


@with_rings
def test_all_ranks_get_the_sum(n, ranks):
    """Of two fields at once, of windows that reach around the ring, too."""
    random = np.random.default_rng(n + ranks)
    bounds = [windows_of(random, n, ranks) for _ in range(2)]
    overlaps = [[Overlaps(rank, lo, hi, n) for lo, hi in bounds] for rank in range(ranks)]
    windows = [
        [random.standard_normal((2, hi[rank] - lo[rank], 3)) for lo, hi in bounds]
        for rank in range(ranks)
    ]
    wanted = [
        sums_of(n, lo, hi, [of_rank[k] for of_rank in windows]) for k, (lo, hi) in enumerate(bounds)
    ]
    on_all_ranks(lambda comm, rank: add_overlaps(comm, overlaps[rank], windows[rank]), ranks)
    for rank, of_rank in enumerate(windows):
        for sums, (lo, hi), window in zip(wanted, bounds, of_rank, strict=True):
            rows = np.arange(lo[rank], hi[rank]) % n
            assert window == pytest.approx(sums[:, rows], rel=1e-12, abs=1e-12)


@with_rings
def test_all_ranks_get_the_whole(n, ranks):
    random = np.random.default_rng(n + ranks)
    lo, hi = windows_of(random, n, ranks)
    windows = [random.standard_normal((2, end - begin, 3)) for begin, end in zip(lo, hi)]
    bounds = [(int(begin), int(end)) for begin, end in zip(lo, hi)]
    whole = np.empty((ranks, 2, n, 3))
    on_all_ranks(lambda comm, rank: add_all(comm, windows[rank], bounds, whole[rank]), ranks)
    assert whole[0] == pytest.approx(sums_of(n, lo, hi, windows), rel=1e-12, abs=1e-12)
    assert all(np.array_equal(found, whole[0]) for found in whole)
