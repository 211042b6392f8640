"""Caches that are stale, damaged or cannot be written: compiled again, never run, never an error."""

import errno
import importlib.util
import pickle
import time
from types import SimpleNamespace

import pytest
from mpi_harness import call, environment

KERNEL = "from hpc_gfmd.kernels.jit import kernel\n\n@kernel\ndef f(x):\n    return 3 * x\n"


@pytest.fixture
def compiled(tmp_path, monkeypatch):
    """compiled(): (value, hits of the cache) of a small kernel, imported anew; .file(kind): its index or code in the cache."""
    numba = pytest.importorskip("numba")
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path / "cache"))
    (tmp_path / "small.py").write_text(KERNEL)

    def run():
        spec = importlib.util.spec_from_file_location("small", tmp_path / "small.py")
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module.f(2.0), sum(module.f.stats.cache_hits.values())

    run.file = lambda kind: next((tmp_path / "cache").rglob(f"*.{kind}"))
    return run


def _stamp():
    from hpc_gfmd.kernels.cache import stamp

    return stamp().encode()


DAMAGE = {
    "index cut": ("nbi", lambda data: data[: len(data) // 2]),
    "index empty": ("nbi", lambda data: b""),
    "index of noise": ("nbi", lambda data: b"\x00\xff" * 100),
    "index of another version of numba": ("nbi", lambda data: pickle.dumps("0.0.1", -1) + b"anything"),
    "index of other sources": ("nbi", lambda data: data.replace(_stamp(), b"0" * 64)),
    "code cut": ("nbc", lambda data: data[:-100]),
    "code empty": ("nbc", lambda data: b""),
    "one bit of the code": ("nbc", lambda data: data[:-2000] + bytes([data[-2000] ^ 1]) + data[-1999:]),
    "code of another program": ("nbc", lambda data: pickle.dumps((b"", b""))),
    "code of another key": ("nbc", lambda data: data.replace(_stamp(), b"0" * 64)),
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_bad_cache_is_compiled_again(damage, compiled, record):
    assert compiled() == (6.0, 0)
    assert compiled() == (6.0, 1)
    kind, change = DAMAGE[damage]
    path = compiled.file(kind)
    data = path.read_bytes()
    assert change(data) != data
    path.write_bytes(change(data))
    begun = time.monotonic()
    assert compiled() == (6.0, 0)
    record("bad cache of compiled kernels", damage, 0, "none; compiled again", time.monotonic() - begun)
    assert compiled() == (6.0, 1)


@pytest.mark.parametrize("how", ["no folder", "disk full"])
def test_a_cache_that_cannot_be_written_is_none(how, compiled, record, monkeypatch):
    from numba.core import caching

    def fails(*_, **__):
        raise OSError(errno.EACCES if how == "no folder" else errno.ENOSPC, how)

    if how == "no folder":  # how numba finds out whether it can write
        monkeypatch.setattr(caching, "tempfile", SimpleNamespace(TemporaryFile=fails, gettempdir=fails))
    else:
        monkeypatch.setattr(caching.IndexDataCacheFile, "_open_for_write", fails)
    begun = time.monotonic()
    assert compiled() == (6.0, 0)
    record("cache of compiled kernels cannot be written", how, 0, "none; compiled in every process", time.monotonic() - begun)
    assert compiled() == (6.0, 0)


@pytest.mark.slow
def test_a_run_with_a_garbled_cache(tmp_path, record):
    """Every file of it half overwritten; the run compiles, and gives the same numbers."""
    (tmp_path / "scene.toml").write_text(
        "[surface]\nkind = 'wave'\namplitude = 0.1\nn = [32, 32]\nperiods = [1, 1]\n[load]\npressure = 0.1\n")
    env = environment(NUMBA_CACHE_DIR=str(tmp_path / "cache"))
    first = call(None, ["run", "scene.toml", "-o", "a.h5"], env=env, cwd=tmp_path, timeout=600)
    assert first.returncode == 0, first.stderr
    files = [p for p in (tmp_path / "cache").rglob("*.nb*") if p.is_file()]
    assert len(files) > 20
    for path in files:
        data = path.read_bytes()
        path.write_bytes(data[: len(data) // 2] + b"\xcc" * (len(data) - len(data) // 2))
    begun = time.monotonic()
    again = call(None, ["run", "scene.toml", "-o", "b.h5"], env=env, cwd=tmp_path, timeout=600)
    assert again.returncode == 0, again.stderr
    record("garbled cache of compiled kernels", f"half of each of its {len(files)} files overwritten; run", 0, "none; compiled again",
           time.monotonic() - begun)
    shown = [call(None, ["show", name, "--json"], env=env, cwd=tmp_path).stdout for name in ("a.h5", "b.h5")]
    assert [line for line in shown[0].splitlines() if "seconds" not in line] == [
        line for line in shown[1].splitlines() if "seconds" not in line]


@pytest.mark.parametrize("content", [b"", b"[]", b"{", b'{"host": 1}', b"\xff\xfe", b"null"])
def test_a_bad_note_of_the_speed_of_this_machine(content, tmp_path, monkeypatch):
    """`plan` measures again."""
    from hpc_gfmd.driver import timing

    monkeypatch.setenv("HPC_GFMD_CACHE", str(tmp_path))
    monkeypatch.setattr(timing, "_measure", lambda dtype: 1e-9)
    (tmp_path / "speed-float64.json").write_bytes(content)
    assert timing.seconds_per_work("float64") == 1e-9
