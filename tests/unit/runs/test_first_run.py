"""What a run says before it compiles."""

import numba
import pytest

from hpc_gfmd.kernels import cache


@pytest.mark.parametrize(
    ("kept", "said"),
    [
        ("nothing", "compiling, once (half a minute)"),
        ("one.kernel", "compiling what this scene needs in addition"),
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
