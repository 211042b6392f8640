"""FFTW's measured plans: cached in one bounded file, equal on all ranks, and never an error."""

import numpy as np
import pytest

from hpc_gfmd.parallel import grid, wisdom
from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.parallel.grid import Grid
from hpc_gfmd.util.caches import keep, kept

N = (120, 84)


@pytest.fixture
def memory(tmp_path, monkeypatch):
    """The wisdom of this process in double precision, emptied, with an empty cache.

    It is restored after the test.
    """
    monkeypatch.setenv("HPC_GFMD_CACHE", str(tmp_path / "cache"))
    process_wisdom = wisdom._wisdom("float64")
    before = process_wisdom.text()
    process_wisdom.replace(b"")
    grid._kept.tables.cache_clear()  # to plan again
    yield process_wisdom
    process_wisdom.replace(before)


def plan(n=N):
    return Grid(n).fft(np.float64)


def lines(text):
    return set(text.split(b"\n"))


def files(folder):
    return sorted(p for p in folder.rglob("*") if p.is_file())


def test_plans_are_read_from_one_file_and_written_only_if_new(memory, tmp_path):
    plan()
    written = memory.text()
    (path,) = files(tmp_path)
    assert path == memory.path
    assert kept(path) == written
    stamp = path.stat().st_mtime_ns
    memory.replace(b"")
    plan()
    assert lines(memory.text()) == lines(written)
    assert path.stat().st_mtime_ns == stamp
    plan((60, 84))
    assert lines(written) < lines(kept(path))
    assert files(tmp_path) == [path]


@pytest.mark.parametrize(
    "content",
    [b"", b"(fftw-3.3.10 fftw_wisdom", b"\0\xff" * 500, b"(" * 5000, b"x" * 2 * wisdom.LIMIT],
)
def test_damaged_wisdom_is_measured_again(content, memory):
    """Content that is no wisdom, under a valid checksum, is replaced."""
    keep(memory.path, content)
    plan()
    assert kept(memory.path) == memory.text()
    assert len(memory.text().splitlines()) > 5


class Rank(SerialComm):
    """One of two ranks; `sent` holds the messages of rank 0."""

    size = 2

    def __init__(self, rank, sent):
        self.rank = rank
        self.sent = sent

    def bcast(self, obj):
        if self.rank == 0:
            self.sent.append(obj)
        return self.sent[-1] if self.rank == 0 else self.sent.pop(0)


def test_ranks_plan_as_rank_0_does(memory):
    """Other ranks take its wisdom, whatever their own and the cache contain."""
    made = []

    def make():
        made.append(memory.text())
        if len(made) == 1:
            plan((16, 250))
        return len(made)

    sent = []
    assert wisdom.planned(Rank(0, sent), np.float64, make, N) == 1
    wanted = memory.text()
    memory.replace(b"")
    plan((64, 100))
    assert wisdom.planned(Rank(1, sent), np.float64, make, N) == 2
    assert lines(made[1]) == lines(wanted)
