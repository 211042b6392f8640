"""FFTW's memory of measured plans ("wisdom"): kept from run to run, the same on all ranks, kept
with every checkpoint.

The same plan rounds in the same way, and planning by measurement takes seconds. So rank 0 plans,
with what the user's cache knows, and the others take over its wisdom. There is one file for each
kind of machine and precision, of bounded size; nobody waits for anybody: of what two runs measure
at the same moment one may be lost, and is measured again some day.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Callable, Hashable
from functools import cache
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from numpy.typing import DTypeLike

from ..util.aligned import empty_aligned
from ..util.caches import cache_folder, keep
from ..util.versions import processor
from .fftw import load_fftw
from .launcher import launcher_rank

if TYPE_CHECKING:
    from .comm import Comm

T = TypeVar("T")

# bytes beyond which a file is left, and begun anew; this process forgets beyond twice that, not
# in the middle of a run
LIMIT = 2**20


def planned(comm: Comm, dtype: DTypeLike, make: Callable[[], T], shapes: Hashable) -> T:
    """Call make(), which makes plans by measurement, so that all ranks plan alike; return what it
    returned. shapes: of these plans. Collective."""
    if load_fftw() is None:
        return make()
    wisdom = _wisdom(np.dtype(dtype).name)
    # writing out all that FFTW knows takes longer than making a plan that is known
    if comm.size == 1 and shapes in wisdom.made:
        return make()
    wisdom.made.add(shapes)
    if comm.size == 1:
        wisdom.version = None  # what is known is not what rank 0 has sent
    if comm.rank == 0:
        if len(wisdom.text()) > 2 * LIMIT:
            wisdom.replace(b"")
        known = wisdom.read()
        plans = make()
        if launcher_rank() == 0 and not _lines(wisdom.text()) <= known:
            wisdom.read()  # what others have found meanwhile
            keep(wisdom.path, wisdom.text())
    if comm.size > 1:
        _take_over(comm, wisdom)
    return plans if comm.rank == 0 else make()


def _take_over(comm: Comm, wisdom: _Wisdom) -> None:
    """Give all ranks what rank 0 knows. It is up to a megabyte, which takes longer to read than to
    send, and for most grids the same as for the one before: it is sent where a rank has another
    version. Collective."""
    text = wisdom.text() if comm.rank == 0 else None
    version = comm.bcast(text and hashlib.sha256(text).digest())
    if comm.max([version != wisdom.version])[0]:
        text = comm.bcast(text)
        if comm.rank != 0:
            wisdom.replace(text)
        wisdom.version = version


def keep_with(folder: str | PathLike) -> None:
    """Write all plans of this process into a folder, for a run that goes on from there."""
    for name in _used:
        keep(Path(folder) / f"wisdom-{name}", _wisdom(name).text())


def take_from(folder: str | PathLike) -> None:
    """Plan as the run did that wrote this folder; what is not there or of another kind of machine
    is measured."""
    for path in Path(folder).glob("wisdom-*"):
        name = path.name.removeprefix("wisdom-")
        if load_fftw() is not None and name in ("float32", "float64"):
            _wisdom(name).replace(_content(path))


class _Wisdom:
    """The wisdom of this process in one precision. What it knows already wins over what is read.
    made: shapes of plans it has made; version: of what rank 0 has sent, None where something else
    is known."""

    def __init__(self, name: str):
        libraries = load_fftw()
        assert libraries is not None
        self.name, self.library = name, libraries[name]
        self._lines: set[bytes] = set()
        self._read: bytes | None = None  # what was in the cache, and these its lines
        self.made: set[Hashable] = set()
        self.version: bytes | None = None
        tiny = empty_aligned((8,), np.result_type(name, np.complex64))
        # The first plan initialises the threads of FFTW, which forgets wisdom read before it.
        self.library.FFT(tiny, tiny, (0,), self.library.C2C_FORWARD, 1, self.library.FFTW_ESTIMATE)
        # Wisdom begins with a line that tells version and instruction sets.
        self.kind = hashlib.sha256(
            self.text().split(b"\n", 1)[0] + processor().encode()
        ).hexdigest()[:16]

    @property
    def path(self) -> Path:
        """The file of this kind of machine in the cache."""
        return cache_folder() / "wisdom" / f"{self.kind}-{self.name}"

    def read(self) -> set[bytes]:
        """Know what is in the cache, too; returns its lines. It is taken over only where it has
        changed: that takes longer than making plans that are known."""
        content = _content(self.path, LIMIT)
        if content != self._read:
            self._lines, self._read = self.add(content), content
        return self._lines

    def text(self) -> bytes:
        """Return all of it, as FFTW writes it; empty where there is no room for a temporary
        file."""
        try:
            with tempfile.NamedTemporaryFile() as file:
                self.library.export_wisdom(os.fsencode(file.name))
                return Path(file.name).read_bytes()
        except OSError:
            return b""

    def add(self, text: bytes) -> set[bytes]:
        """Know this, too; returns its lines, none if it could not be understood."""
        try:
            with tempfile.NamedTemporaryFile() as file:
                file.write(text)
                file.flush()
                known = text and self.library.import_wisdom(os.fsencode(file.name))
                return _lines(text) if known else set()
        except OSError:
            return set()

    def replace(self, text: bytes) -> None:
        """Know this and nothing else."""
        self._read = self.version = None
        self.made.clear()
        self.library.forget_wisdom()
        self.add(text)


_used: list[str] = []  # precisions


@cache
def _wisdom(name: str) -> _Wisdom:
    _used.append(name)
    return _Wisdom(name)


def _content(path: Path, most: float = np.inf) -> bytes:
    """Read what a file of at most so many bytes holds; nothing where it is longer or cannot be
    read."""
    try:
        content = path.read_bytes()
    except OSError:
        return b""
    return content if len(content) <= most else b""


def _lines(text: bytes) -> set[bytes]:
    """Split wisdom into lines: one for each (part of a) plan."""
    return set(text.split(b"\n"))
