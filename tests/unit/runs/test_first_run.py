"""Messages about compilation."""

import numba
import numpy as np
import pytest

import hpc_gfmd
from hpc_gfmd.kernels import cache
from hpc_gfmd.runs import loads


@pytest.mark.parametrize(
    ("existing", "words"),
    [
        ("nothing", "once"),
        ("of_make_surface.kernel", "once"),
        ("update_passes.kernel", "in addition"),
    ],
)
def test_compilation_is_announced_once(tmp_path, monkeypatch, existing, words):
    monkeypatch.setattr(cache, "folder", lambda: tmp_path)
    monkeypatch.setattr(cache, "TOLD_SECONDS", np.inf)  # no second message about the time
    (tmp_path / existing).touch()
    messages = []
    functions = [numba.njit(lambda x, k=k: x + k) for k in range(2)]
    with cache.on_first_compile(messages.append):
        assert not messages
        assert [function(1) for function in functions] == [1, 2]
    assert len(messages) == 1
    assert messages[0].startswith("compiling")
    assert words in messages[0]
    with cache.on_first_compile(messages.append):
        assert functions[0](2) == 2
    assert len(messages) == 1
    with cache.on_first_compile(None):
        assert numba.njit(lambda x: -x)(1) == -1


@pytest.mark.parametrize("progress", [False, True])
def test_solve_announces_compilation(progress, monkeypatch, capsys):
    """On standard error, with and without progress=True."""
    original = loads.sweep_of

    def compile_and_sweep(*arguments):
        numba.njit(lambda x: x + 5)(1)
        return original(*arguments)

    monkeypatch.setattr(loads, "sweep_of", compile_and_sweep)
    hpc_gfmd.solve(
        np.add.outer(np.arange(8) % 3, np.arange(8) % 2) * 0.1, p_star=0.1, progress=progress
    )
    captured = capsys.readouterr()
    assert "compiling" in captured.err
    assert "compiling" not in captured.out
