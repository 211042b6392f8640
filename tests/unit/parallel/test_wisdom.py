"""FFTW's measured plans: kept once, the same on all ranks and in every continuation, bounded, and
never an error."""

import numpy as np
import pytest

from hpc_gfmd.parallel import grid, wisdom
from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.parallel.fftw import load_fftw
from hpc_gfmd.parallel.grid import Grid
from hpc_gfmd.util.caches import keep, kept

pytestmark = pytest.mark.skipif(load_fftw() is None, reason="FFTW is missing")
N = (120, 84)


@pytest.fixture
def memory(tmp_path, monkeypatch):
    """The wisdom of this process in double precision, with an empty cache and nothing known;
    afterwards as before."""
    monkeypatch.setenv("HPC_GFMD_CACHE", str(tmp_path / "cache"))
    found = wisdom._wisdom("float64")
    before = found.text()
    found.replace(b"")
    grid._kept.tables.cache_clear()  # so that all is planned anew
    yield found
    found.replace(before)


def plan(n=N):
    return Grid(n).fft(np.float64)


def files(folder):
    return sorted(p for p in folder.rglob("*") if p.is_file())


def test_one_file_that_is_read_again_and_not_written_when_all_is_known(memory, tmp_path):
    plan()
    first = memory.text()
    (path,) = files(tmp_path)
    assert path == memory.path
    assert kept(path) == first
    stamp = path.stat().st_mtime_ns
    memory.replace(b"")
    plan()
    assert wisdom._lines(memory.text()) == wisdom._lines(first)
    assert path.stat().st_mtime_ns == stamp
    plan((60, 84))
    assert wisdom._lines(first) < wisdom._lines(kept(path))
    assert files(tmp_path) == [path]


def test_a_campaign_of_many_grids_is_bounded(memory, tmp_path, monkeypatch):
    """And what each planned last is known."""
    monkeypatch.setattr(wisdom, "LIMIT", 5000)
    for k in range(8):
        plan((24 + 2 * k, 36 + 2 * k))
        (path,) = files(tmp_path)
        assert path.stat().st_size < 3 * wisdom.LIMIT
        assert wisdom._lines(memory.text()) <= wisdom._lines(kept(path)) | {b""}


@pytest.mark.parametrize(
    "content",
    [b"", b"(fftw-3.3.10 fftw_wisdom", b"\0\xff" * 500, b"(" * 5000, b"x" * 2 * wisdom.LIMIT],
)
def test_what_is_no_wisdom_is_measured_again(content, memory):
    """Though it is what was kept."""
    keep(memory.path, content)
    plan()
    assert kept(memory.path) == memory.text()
    assert len(memory.text().splitlines()) > 5


def test_a_cache_that_cannot_be_written_is_none(memory, tmp_path):
    (tmp_path / "cache").write_text("a file where the folder should be")
    assert plan().plans.rows_forward is not None


class Rank(SerialComm):
    """One of two ranks; what rank 0 sends is in `sent`."""

    size = 2

    def __init__(self, rank, sent):
        self.rank, self.sent = rank, sent

    def bcast(self, obj):
        if self.rank == 0:
            self.sent.append(obj)
        return self.sent[-1] if self.rank == 0 else self.sent.pop(0)


def test_ranks_plan_as_rank_0_does(memory):
    """By its wisdom alone, whatever they knew and the cache knows."""
    made = []

    def make():
        made.append(memory.text())
        if len(made) == 1:
            plan((16, 250))
        return len(made)

    sent = []
    assert wisdom.planned(Rank(0, sent), np.float64, make, N) == 1
    assert len(sent) == 2  # a version, and what it stands for
    wanted = memory.text()
    memory.replace(b"")
    plan((64, 100))
    assert wisdom.planned(Rank(1, sent), np.float64, make, N) == 2
    assert wisdom._lines(made[1]) == wisdom._lines(wanted)
