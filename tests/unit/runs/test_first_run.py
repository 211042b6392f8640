"""What a run says before it compiles."""

import numba
import numpy as np
import pytest

import hpc_gfmd
from hpc_gfmd.kernels import cache
from hpc_gfmd.runs import in_memory


@pytest.mark.parametrize(
    ("kept", "said"),
    [
        ("nothing", "compiling, once"),
        ("of_make_surface.kernel", "compiling, once"),
        ("update_passes.kernel", "compiling what this scene needs in addition"),
    ],
)
def test_compiling_is_announced_once_and_only_if_something_is_compiled(
    tmp_path, monkeypatch, kept, said
):
    monkeypatch.setattr(cache, "folder", lambda: tmp_path)
    (tmp_path / kept).touch()
    told, functions = [], [numba.njit(lambda x, k=k: x + k) for k in range(2)]
    with cache.on_first_compile(told.append):
        assert not told
        assert [function(1) for function in functions] == [1, 2]
    assert len(told) == 1
    assert told[0].startswith(said)
    with cache.on_first_compile(told.append):
        assert functions[0](2) == 2
    assert len(told) == 1
    with cache.on_first_compile(None):
        assert numba.njit(lambda x: -x)(1) == -1


def test_it_is_said_if_nothing_can_be_kept(monkeypatch):
    monkeypatch.setattr(cache, "folder", lambda: None)
    told = []
    with cache.on_first_compile(told.append):
        assert numba.njit(lambda x: x - 1)(1) == 0
    assert len(told) == 1
    assert "every" in told[0]
    assert "HPC_GFMD_CACHE" in told[0]


def test_how_long_it_took_is_said(monkeypatch):
    """After it, where that is long enough to be noticed."""
    for least, count in ((0.0, 2), (np.inf, 1)):
        monkeypatch.setattr(cache, "TOLD_SECONDS", least)
        told = []
        with cache.on_first_compile(told.append):
            assert numba.njit(lambda x: x - 2)(1) == -1
        assert len(told) == count


@pytest.mark.parametrize("progress", [False, True])
def test_a_solve_in_python_says_that_it_compiles(progress, monkeypatch, capsys):
    """On standard error, with and without progress=True."""
    original = in_memory.sweep_of

    def compile_and_sweep(*arguments):
        numba.njit(lambda x: x + 5)(1)
        return original(*arguments)

    monkeypatch.setattr(in_memory, "sweep_of", compile_and_sweep)
    hpc_gfmd.solve(
        np.add.outer(np.arange(8) % 3, np.arange(8) % 2) * 0.1, p_star=0.1, progress=progress
    )
    captured = capsys.readouterr()
    assert "compiling" in captured.err
    assert "compiling" not in captured.out
