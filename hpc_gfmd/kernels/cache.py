"""Keep compiled kernels from run to run, in a folder for each state of sources, versions,
processor.

numba's own cache, which is off, looks at a kernel's own source file only, but functions of others
are compiled in. It also trusts the bytes that it finds, and numbers files, so that two processes
mix them up. So this module writes one file a kernel and signature, with a checksum.
"""

import gc
import hashlib
import os
import pickle
import shutil
import stat
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple, Self

import llvmlite
import numba
import numpy
from llvmlite import binding
from numba.core import event
from numba.core.caching import CompileResultCacheImpl
from numba.core.serialize import dumps

from ..util.caches import cache_folder, keep, kept
from ..util.plugins import sources_added

LARGEST = "update_passes"  # the kernel that is kept wherever a contact has been solved
TOLD_SECONDS = 1.0  # of compiling, from which on it is said how long it took
NEWEST = 4  # states whose folders are kept
ROOM = 64 * 2**20  # bytes that must be free
SUFFIX = ".kernel"  # of the files


class KernelFiles(NamedTuple):
    """The files of one kernel's code, one for each signature: `stem`.HASH.kernel."""

    stem: Path
    name: str  # of the kernel among all
    state: str  # what else its code depends on: `stamp` and its own source

    @classmethod
    def of(cls, function: Callable[..., Any], kind: str) -> Self | None:
        """Return the files in `folder()` of a kernel of a kind, made of a function; None without a
        folder or a source, and for a closure, which its source does not describe.
        """
        path = folder()
        if path is None or function.__closure__:
            return None
        code = function.__code__
        try:
            source = hashlib.sha256(Path(code.co_filename).read_bytes()).hexdigest()
        except OSError:
            return None
        name = f"{kind} {code.co_filename}:{code.co_firstlineno} {function.__qualname__}"
        return cls(path / function.__name__, name, f"{stamp()} {source}")

    def load(self, types: tuple, context: Any) -> Any:
        """Return the code for types of arguments; None if none is whole and of this state."""
        path, purpose = self._file(types, context)
        content = kept(path, purpose)
        if content is None:
            return None
        _log(f"data loaded from {path}")
        context.refresh()
        return CODE.rebuild(context, pickle.loads(content))

    def save(self, types: tuple, code: Any) -> None:
        """Write the code for types of arguments; errors of the file system are ignored."""
        if not code.library.has_dynamic_globals:  # addresses, which hold in this process alone
            path, purpose = self._file(types, code.target_context)
            keep(path, dumps(CODE.reduce(code)), purpose)
            _log(f"data saved to {path}")

    def _file(self, types: tuple, context: Any) -> tuple[Path, str]:
        """Return the file of a signature, and the purpose that `keep` and `kept` check."""
        key = f"{self.name} {types} {context.codegen().magic_tuple()}"
        digest = hashlib.sha256(key.encode()).hexdigest()[:16]
        return self.stem.with_name(f"{self.stem.name}.{digest}{SUFFIX}"), f"{self.state} {key}"


class Code(CompileResultCacheImpl):  # type: ignore[misc]
    """numba's form of compiled code in files, without its own idea of where these are."""

    def __init__(self) -> None:
        pass


CODE = Code()


def _log(text: str) -> None:
    """Print a line as numba's own cache does, if NUMBA_DEBUG_CACHE is set."""
    if numba.config.DEBUG_CACHE:
        print(f"[cache] {text}")


@cache
def stamp() -> str:
    """Return a hash of what machine code depends on: kernels, laws, versions, processor."""
    made_by = (
        numba.__version__,
        llvmlite.__version__,
        numpy.__version__,
        binding.get_host_cpu_name(),
    )
    digest = hashlib.sha256(" ".join(made_by).encode())
    kernels = Path(__file__).parent
    # laws of attraction are compiled in, too
    laws = [*sorted((kernels.parent / "laws").glob("*.py")), *sources_added("hpc_gfmd.laws")]
    for path in [*sorted(kernels.glob("*.py")), *laws]:
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


@contextmanager
def on_first_compile(say: Callable[[str], object] | None) -> Iterator[None]:
    """Call say(text) before the first compilation in this block, and after slow ones."""

    def announce() -> None:
        path = folder()
        if say is None:
            return
        if path is None:
            say(
                "compiling (up to half a minute), at every start: there is no folder to keep it in,"
                " HPC_GFMD_CACHE=FOLDER names one"
            )
        elif any(path.glob(f"{LARGEST}*{SUFFIX}")):
            say("compiling what this scene needs in addition, once (up to half a minute)")
        else:
            say("compiling, once (up to half a minute)")

    clock = _Clock(announce)
    try:
        with event.install_listener("numba:compile", clock):
            yield
    finally:
        if say is not None and clock.seconds >= TOLD_SECONDS:
            say(f"compiled in {clock.seconds:.0f} s")


class _Clock(event.Listener):  # type: ignore[misc]
    """Measures `seconds` of compilations; garbage collection, 7 % of them, is off meanwhile."""

    def __init__(self, announce: Callable[[], object]) -> None:
        self.announce: Callable[[], object] | None = announce
        self.seconds = 0.0
        self.depth = 0  # a kernel's pieces are compiled while it is

    def on_start(self, _: object) -> None:
        """Announce the first compilation, and begin to count time with the outermost."""
        announce = self.announce
        self.announce = None
        if announce is not None:
            announce()
        if self.depth == 0:
            self.begin = time.monotonic()
            self.collects = gc.isenabled()
            gc.disable()
        self.depth += 1

    def on_end(self, _: object) -> None:
        """Add the time since the outermost compilation began, once that ends."""
        self.depth -= 1
        if self.depth == 0:
            self.seconds += time.monotonic() - self.begin
            if self.collects:
                gc.enable()


def folder() -> Path | None:
    """Return the folder for machine code of this `stamp`, or None: in NUMBA_CACHE_DIR, the user's
    cache, or else the machine's temporary folder, so that not every rank compiles.
    """
    root: Path | None
    if numba.config.CACHE_DIR:
        root = Path(numba.config.CACHE_DIR)
    else:
        root = cache_folder()
        root = root and root / "kernels"
    return (root and _folder(root, stamp())) or _temporary_folder(stamp())


def _temporary_folder(state: str) -> Path | None:
    """Return the folder of a stamp among temporary files, which only this user can write to."""
    user = getattr(os, "getuid", lambda: "user")()
    root = Path(tempfile.gettempdir()) / f"hpc-gfmd-{user}"
    try:
        root.mkdir(mode=0o700, exist_ok=True)
        status = root.lstat()
    except OSError:
        return None
    is_ours = stat.S_ISDIR(status.st_mode) and status.st_uid == user and not status.st_mode & 0o077
    return _folder(root, state) if is_ours or os.name == "nt" else None


@cache
def _folder(root: Path, state: str) -> Path | None:
    """Return a stamp's folder, and remove all but the NEWEST; None if it cannot be written."""
    path = root / f"hpc-gfmd-{state}"
    try:
        if not path.is_dir():
            path.mkdir(parents=True, exist_ok=True)
            states = sorted(root.glob("hpc-gfmd-*"), key=lambda folder: folder.stat().st_mtime)
            for old in states[:-NEWEST]:
                shutil.rmtree(old, ignore_errors=True)
        tempfile.TemporaryFile(dir=path).close()
        return path if shutil.disk_usage(path).free > ROOM else None
    except OSError:
        return None
