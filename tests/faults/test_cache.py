"""Caches that are stale, damaged or not writable are never used and never an error."""

import errno
import importlib.util
import os
import pickle
import shutil
import sys
import tempfile

import numba
import pytest
from contacts import WAVE_SCENE
from faults.test_readers import EDITS, changed
from hypothesis import given, settings
from mpi_harness import environment, python
from numba.core import event

from hpc_gfmd.util.caches import keep, kept

KERNELS = """
from hpc_gfmd.kernels.jit import kernel

@kernel
def triple(x):
    return 3 * x

@kernel
def square(x):
    return x * x
"""


@pytest.fixture
def compiled(tmp_path, monkeypatch):
    """compiled() imports a small kernel and returns (3 * 2.0, whether it was compiled).

    compiled.module() imports all kernels of the file; compiled.files() lists the cache.
    """
    cache = tmp_path / "cache"
    # numba reads all its variables again when one has changed
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(cache))
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(cache))
    (tmp_path / "small.py").write_text(KERNELS)

    def module():
        spec = importlib.util.spec_from_file_location("small", tmp_path / "small.py")
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module

    def run():
        with event.install_recorder("numba:compile") as compilations:
            return module().triple(2.0), bool(compilations.buffer)

    run.module = module
    run.files = lambda: sorted(cache.rglob("*.kernel"))
    return run


DAMAGE = {
    "cut": lambda data: data[:-100],
    "empty": lambda data: b"",
    "noise": lambda data: b"\xcc" * len(data),
    "one bit": lambda data: data[:-50] + bytes([data[-50] ^ 4]) + data[-49:],
    "valid but empty": lambda data: pickle.dumps((b"", b"")),
    "as numba writes it, without a checksum": lambda data: data[32:],
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_damaged_kernel_is_compiled_again(damage, compiled):
    assert compiled() == (6.0, True)
    assert compiled() == (6.0, False)
    (path,) = compiled.files()
    data = path.read_bytes()
    assert DAMAGE[damage](data) != data
    path.write_bytes(DAMAGE[damage](data))
    assert compiled() == (6.0, True)
    assert compiled() == (6.0, False)
    assert compiled.files() == [path]


def test_a_changed_source_is_compiled_again(compiled, tmp_path):
    assert compiled() == (6.0, True)
    source = tmp_path / "small.py"
    # of another length: Python knows its own bytecode by seconds and length
    source.write_text(KERNELS.replace("3 * x", "3 * x + 2"))
    assert compiled() == (8.0, True)
    assert compiled() == (8.0, False)


@pytest.mark.parametrize("reason", ["no folder", "no room", "disk full", "no permission"])
def test_a_cache_that_cannot_be_written(reason, compiled, monkeypatch, tmp_path):
    def fails(*_, **__):
        raise OSError(errno.ENOSPC, reason)

    if reason == "no folder":
        (tmp_path / "cache").write_text("a file where the folder should be")
    elif reason == "no room":
        monkeypatch.setattr(
            shutil, "disk_usage", lambda _: shutil._ntuple_diskusage(10**9, 10**9, 0)
        )
    elif reason == "disk full":
        monkeypatch.setattr(os, "replace", fails)
    else:
        monkeypatch.setattr(os, "mkdir", fails)
    monkeypatch.setattr(tempfile, "gettempdir", lambda: str(tmp_path / "nowhere"))
    assert compiled() == (6.0, True)
    assert compiled() == (6.0, True)
    assert compiled.files() == []


def test_other_sources_have_another_folder_and_few_are_kept(compiled, monkeypatch, tmp_path):
    """A kernel may contain a function of another file, at which numba does not look."""
    from hpc_gfmd.kernels import cache

    users = numba.config.CACHE_DIR
    for k in range(cache.NEWEST + 3):
        monkeypatch.setattr(cache, "stamp", lambda k=k: f"state{k}")
        assert compiled() == (6.0, True)
        assert compiled() == (6.0, False)
        os.utime(tmp_path / "cache" / f"hpc-gfmd-state{k}", (k, k))
    assert sorted(path.name for path in (tmp_path / "cache").iterdir()) == [
        f"hpc-gfmd-state{k}" for k in (3, 4, 5, 6)
    ]
    assert users == numba.config.CACHE_DIR


def test_changed_bytes_are_detected(tmp_path):
    original = bytes(range(256)) * 3
    path = tmp_path / "file"
    keep(path, original)
    data = path.read_bytes()
    assert kept(path) == original
    assert kept(path, "something else") is None

    @settings(max_examples=300)
    @given(EDITS)
    def check(edits):
        path.write_bytes(changed(data, edits))
        assert kept(path) == (original if path.read_bytes() == data else None)

    check()
    path.rename(tmp_path / "other")
    assert kept(tmp_path / "other") is None
    assert kept(tmp_path) is None


SOLVE = """
import hpc_gfmd
wall = hpc_gfmd.make_surface("self-affine", hurst=0.8, L_over_lam_l=1, lam_l_over_lam_s=8,
                             lam_s_over_a=2, seed=1)
print(hpc_gfmd.solve(wall, 0.1, accuracy=1e-2).a_r.hex())
"""


WITHOUT_A_NAME = """
import os, pwd

def nobody(*_):
    raise KeyError("no such user")

pwd.getpwuid = pwd.getpwnam = nobody
for name in ("HOME", "USER", "LOGNAME", "HPC_GFMD_CACHE", "XDG_CACHE_HOME", "NUMBA_CACHE_DIR"):
    os.environ.pop(name, None)
"""


def test_no_cache_in_a_relative_home(monkeypatch):
    from hpc_gfmd.util.caches import cache_folder

    for name in ("HPC_GFMD_CACHE", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("HOME", "relative")
    assert cache_folder() is None


@pytest.mark.parametrize(
    ("commands", "files"),
    [  # as in a container whose user has no entry in the password file
        (["info", "init", "persson --hurst 0.8 --eps-f 0.01 --p-star 0.1"], ["scene.toml"]),
        # compiles
        pytest.param(
            ["init", "plan scene.toml", "run scene.toml --set surface.lam_l_over_lam_s=8"],
            ["contact.h5", "scene.toml"],
            marks=pytest.mark.slow,
        ),
    ],
)
def test_commands_without_a_home(commands, files, tmp_path):
    program = f"""{WITHOUT_A_NAME}
from hpc_gfmd.commands.cli import main
print([main(command.split()) for command in {commands}])
"""
    completed = python(None, ["-c", program], environment(), tmp_path)
    assert completed.returncode == 0, completed.stderr
    assert completed.stdout.endswith("[0, 0, 0]\n"), completed.stdout
    assert sorted(path.name for path in tmp_path.iterdir()) == files


@pytest.mark.slow
def test_numba_without_compilation_is_refused(tmp_path):
    """With numba's switch for debugging Python would call FFTW by an address."""
    completed = python(None, ["-c", SOLVE], environment(NUMBA_DISABLE_JIT="1"))
    assert completed.returncode == 1
    assert "NUMBA_DISABLE_JIT" in completed.stderr.splitlines()[-1]
    (tmp_path / "scene.toml").write_text(WAVE_SCENE)
    words = ["-m", "hpc_gfmd", "run", "scene.toml"]
    completed = python(None, words, environment(NUMBA_DISABLE_JIT="1"), tmp_path)
    assert (completed.returncode, completed.stderr.count("\n")) == (2, 1), completed.stderr
    assert "NUMBA_DISABLE_JIT" in completed.stderr
    assert sys.platform != "linux" or sorted(os.listdir(tmp_path)) == ["scene.toml"]
