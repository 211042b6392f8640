"""Caches that are stale, damaged or cannot be written: compiled again, never run, never an
error."""

import errno
import importlib.util
import os
import pickle
import platform
import shutil

import pytest

KERNEL = "from hpc_gfmd.kernels.jit import kernel\n\n@kernel\ndef f(x):\n    return 3 * x\n"


@pytest.fixture
def compiled(tmp_path, monkeypatch):
    """compiled(): (value, hits of the cache) of a small kernel, imported anew; .file(kind): its
    index or code in the cache."""
    numba = pytest.importorskip("numba")
    from hpc_gfmd.kernels.cache import retry_without_cache

    monkeypatch.setenv(
        "NUMBA_CACHE_DIR", str(tmp_path / "cache")
    )  # numba reads its variables anew where one has changed
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path / "cache"))
    (tmp_path / "small.py").write_text(KERNEL)

    def run():
        spec = importlib.util.spec_from_file_location("small", tmp_path / "small.py")
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return retry_without_cache(lambda: module.f(2.0)), sum(module.f.stats.cache_hits.values())

    run.file = lambda kind: next((tmp_path / "cache").rglob(f"*.{kind}"))
    return run


DAMAGE = {
    "index cut": ("nbi", lambda data: data[: len(data) // 2]),
    "index of another version of numba": (
        "nbi",
        lambda data: pickle.dumps("0.0.1", -1) + b"anything",
    ),
    "code cut": ("nbc", lambda data: data[:-100]),
    "code of another program": ("nbc", lambda data: pickle.dumps((b"", b""))),
    "code of noise": ("nbc", lambda data: b"\xcc" * len(data)),
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_bad_cache_is_compiled_again(damage, compiled):
    assert compiled() == (6.0, 0)
    assert compiled() == (6.0, 1)
    kind, change = DAMAGE[damage]
    path = compiled.file(kind)
    data = path.read_bytes()
    assert change(data) != data
    path.write_bytes(change(data))
    assert compiled() == (6.0, 0)
    assert compiled() == (6.0, 1)


@pytest.mark.parametrize("how", ["no folder", "no room", "disk full"])
def test_a_cache_that_cannot_be_written_is_none(how, compiled, monkeypatch, tmp_path):
    def fails(*_, **__):
        raise OSError(errno.ENOSPC, how)

    if how == "no folder":
        (tmp_path / "cache").write_text("a file where the folder should be")
    elif how == "no room":
        monkeypatch.setattr(
            shutil, "disk_usage", lambda _: shutil._ntuple_diskusage(10**9, 10**9, 0)
        )
    else:
        monkeypatch.setattr(os, "replace", fails)
    assert compiled() == (6.0, 0)
    assert compiled() == (6.0, 0)
    assert not list(tmp_path.rglob("*.nb?"))


def test_other_sources_have_another_folder_and_few_are_kept(compiled, monkeypatch, tmp_path):
    """A function that is compiled into a kernel may live in another file, which numba does not look
    at."""
    import numba

    from hpc_gfmd.kernels import cache

    users = numba.config.CACHE_DIR
    for k in range(cache.NEWEST + 3):
        monkeypatch.setattr(cache, "stamp", lambda k=k: f"state{k}")
        assert compiled() == (6.0, 0)
        assert compiled() == (6.0, 1)
        os.utime(tmp_path / "cache" / f"hpc-gfmd-state{k}", (k, k))
    assert sorted(path.name for path in (tmp_path / "cache").iterdir()) == [
        f"hpc-gfmd-state{k}" for k in (3, 4, 5, 6)
    ]
    assert users == numba.config.CACHE_DIR


def test_an_error_that_is_not_the_caches_is_raised(compiled):
    from hpc_gfmd.kernels.cache import retry_without_cache

    calls = []
    with pytest.raises(ZeroDivisionError):
        retry_without_cache(lambda: calls.append(1) or 1 / 0)
    assert len(calls) == 1


@pytest.mark.parametrize("content", [b"", b"[]", b"\xff\xfe", b"null"])
def test_a_bad_note_of_the_speed_of_this_machine(content, tmp_path, monkeypatch):
    """`plan` measures again."""
    from hpc_gfmd.runs import timing

    monkeypatch.setenv("HPC_GFMD_CACHE", str(tmp_path))
    measured = iter([1e-9, 3e-9])
    monkeypatch.setattr(timing, "_measure", lambda dtype: next(measured))
    (tmp_path / f"speed-float64-{platform.node()}").write_bytes(content)
    assert timing.seconds_per_work("float64") == 1e-9
    monkeypatch.setenv("HPC_GFMD_CACHE", "/proc/none")
    assert timing.expected_seconds(1.0, ["float64"] * 3, (1, 2)) == pytest.approx(18e-9)


def test_kept_code_calls_no_copy_of_a_piece():
    """It would be another one than that of code just compiled, with other last bits."""
    from hpc_gfmd.kernels.multilevel import restrict_row

    assert restrict_row.targetoptions["forceinline"]
