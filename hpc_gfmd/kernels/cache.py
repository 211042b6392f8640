"""Where numba keeps compiled kernels: in a folder for each state of their sources, versions and
kind of processor.

numba looks at the source file of a kernel only, but other files' functions are compiled into it.
What it cannot read or write it raises; `retry_without_cache` then empties the folder and begins
again.
"""

import hashlib
import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from traceback import walk_tb
from types import TracebackType
from typing import TypeVar

import llvmlite
import numba
import numpy
from llvmlite import binding
from numba.core import event

from ..util.caches import cache_folder
from ..util.plugins import sources_added

NEWEST = 4  # states whose folders are kept
ROOM = 64 * 2**20  # bytes that must be free
T = TypeVar("T")
ATTEMPTS = 100  # on a disk without room every kernel may fail once: when it is to be written


@cache
def stamp() -> str:
    """Return a text that changes with any kernel and with all that makes machine code of them."""
    made_by = (
        numba.__version__,
        llvmlite.__version__,
        numpy.__version__,
        binding.get_host_cpu_name(),
    )
    digest = hashlib.sha256(" ".join(made_by).encode())
    here = Path(__file__).parent
    # laws of attraction are compiled in, too
    laws = [*sorted((here.parent / "laws").glob("*.py")), *sources_added("hpc_gfmd.laws")]
    for path in [*sorted(here.glob("*.py")), *laws]:
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


@contextmanager
def cached() -> Iterator[bool]:
    """Tell numba the folder, for a block; gives whether there is one that can be written.
    NUMBA_CACHE_DIR moves it."""
    users, path = numba.config.CACHE_DIR, folder()
    numba.config.CACHE_DIR = str(path or users)
    try:
        yield path is not None
    finally:
        numba.config.CACHE_DIR = users  # other packages' kernels are not ours


@contextmanager
def on_first_compile(say: Callable[[str], object] | None) -> Iterator[None]:
    """Call say(text), if it is not None, once in a block: before the first kernel is compiled that
    has not been kept."""

    def first() -> None:
        here = folder()
        kept = here is not None and any(here.rglob("*.nbi"))
        if say:
            say(
                "compiling what this scene needs in addition, once (some seconds)"
                if kept
                else "compiling, once (half a minute)"
            )

    with event.install_listener("numba:compile", _Once(first)):
        yield


class _Once(event.Listener):  # type: ignore[misc]
    """Calls a function when the first event begins."""

    def __init__(self, call: Callable[[], object]) -> None:
        self.call: Callable[[], object] | None = call

    def on_start(self, _: object) -> None:
        call, self.call = self.call, None
        if call is not None:
            call()

    def on_end(self, _: object) -> None:
        pass


def folder() -> Path | None:
    """Return the folder of the present state, or None where it cannot be written."""
    return _folder(Path(numba.config.CACHE_DIR or cache_folder() / "kernels"), stamp())


@cache
def _folder(root: Path, state: str) -> Path | None:
    """Return the folder of a state in a root, as `folder`; making it removes the oldest ones."""
    path = root / f"hpc-gfmd-{state}"
    try:
        if not path.is_dir():
            path.mkdir(parents=True, exist_ok=True)
            states = sorted(root.glob("hpc-gfmd-*"), key=lambda other: other.stat().st_mtime)
            for old in states[:-NEWEST]:
                shutil.rmtree(old, ignore_errors=True)
        tempfile.TemporaryFile(dir=path).close()
        return path if shutil.disk_usage(path).free > ROOM else None
    except OSError:
        return None


def retry_without_cache(call: Callable[[], T]) -> T:
    """Return call(), with emptied folders where numba fails to read or to write them."""
    for _ in range(ATTEMPTS):
        try:
            return call()
        except Exception as error:
            if not _of_numbas_cache(error.__traceback__):
                raise
            _empty()
    return call()


def _of_numbas_cache(traceback: TracebackType | None) -> bool:
    return any(
        frame.f_globals.get("__name__") == "numba.core.caching" for frame, _ in walk_tb(traceback)
    )


def _empty() -> None:
    """Remove all that was kept of this state; the folders stay."""
    here = folder()
    for file in here.rglob("*.nb*") if here else ():
        with suppress(OSError):
            file.unlink()
