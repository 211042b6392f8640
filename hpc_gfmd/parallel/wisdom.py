"""FFTW's memory of measured plans ("wisdom"): kept from run to run, the same on all ranks.

The same plan rounds in the same way, and planning by measurement takes seconds. So rank 0 plans,
with what the user's cache knows, and the others take over its wisdom. There is one file for each
kind of machine and precision, of bounded size. No process waits for another: of what two runs
measure at the same moment one may be lost, and is measured again later.
"""

from __future__ import annotations

import ctypes
import hashlib
from collections.abc import Callable, Hashable
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import DTypeLike

from ..util.caches import cache_folder, keep, kept
from ..util.versions import processor
from .fftw import PREFIXES, load_fftw
from .launcher import launcher_rank

if TYPE_CHECKING:
    from .comm import Comm

T = TypeVar("T")

# bytes beyond which a file is left, and begun anew; this process forgets beyond twice that, not
# in the middle of a run
LIMIT = 2**20


def planned(comm: Comm, dtype: DTypeLike, make: Callable[[], T], shapes: Hashable) -> T:
    """Make plans by measurement, the same ones on all ranks. Collective.

    Rank 0 reads wisdom from the user's cache, plans, and adds to the cache what is new; the other
    ranks get its wisdom. Without FFTW make() is called and nothing else happens.

    Parameters
    ----------
    comm : Comm
        All ranks.
    dtype : dtype
        Of the real numbers.
    make : function
        make() makes the plans of this rank; it is called once.
    shapes : hashable
        Identifies these plans: if a single process has made plans with these `shapes` before, it
        does not read or write the cache.

    Returns
    -------
    object
        What make() returned.
    """
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
        lines_kept = _lines(wisdom.read())
        plans = make()
        if launcher_rank() == 0 and not _lines(wisdom.text()) <= lines_kept:
            wisdom.read()  # what others have found meanwhile
            if wisdom.path:
                keep(wisdom.path, wisdom.text())
    if comm.size > 1:
        _take_over(comm, wisdom)
    return plans if comm.rank == 0 else make()


def _take_over(comm: Comm, wisdom: _Wisdom) -> None:
    """Replace the wisdom of all ranks by that of rank 0. Collective.

    It has up to a megabyte, which takes longer to read than to send, and is mostly the same as for
    the grid before: it is sent only if the `version` of a rank differs. Sets `version` if it is.
    """
    text = wisdom.text() if comm.rank == 0 else None
    version = comm.bcast(text and hashlib.sha256(text).digest())
    if comm.max([version != wisdom.version])[0]:
        text = comm.bcast(text)
        if comm.rank != 0:
            wisdom.replace(text)
        wisdom.version = version


class _Wisdom:
    """The wisdom of this process in one precision, which FFTW itself holds.

    Parameters
    ----------
    name : str
        The precision: "float32" or "float64". FFTW must be there.

    Attributes
    ----------
    made : set
        Shapes of the plans that were made.
    version : bytes or None
        Hash of the wisdom that rank 0 has sent; None if other wisdom has come in since.
    kind : str
        Hash of the version of FFTW and the kind of processor, for the name of the file.
    """

    def __init__(self, name: str):
        libraries = load_fftw()
        assert libraries is not None
        self.name = name
        self.library = libraries[name]
        self._read = b""  # what was in the cache
        self.made: set[Hashable] = set()
        self.version: bytes | None = None
        # The first call starts the threads of FFTW, which forgets wisdom read before it.
        self._function("plan_with_nthreads")(1)
        # Wisdom begins with a line that tells version and instruction sets.
        self.kind = hashlib.sha256(
            self.text().split(b"\n", 1)[0] + processor().encode()
        ).hexdigest()[:16]

    @property
    def path(self) -> Path | None:
        """The file in the cache for this kind of machine and precision; None without a cache."""
        folder = cache_folder()
        return folder and folder / "wisdom" / f"{self.kind}-{self.name}"

    def read(self) -> bytes:
        """Add the wisdom in the cache to that of this process, and return it as text.

        Returns b"" if there is none, or if FFTW rejects it. Wisdom that has not changed since the
        last call is not added again, because that takes longer than making plans that are known.
        """
        content = (self.path and kept(self.path)) or b""
        if len(content) > LIMIT:
            content = b""
        if content != self._read:
            self._read = content if self._add(content) else b""
        return self._read

    def text(self) -> bytes:
        """Return all wisdom of this process as FFTW writes it."""
        export = self._function("export_wisdom_to_string")
        export.restype = ctypes.c_void_p
        memory = ctypes.c_void_p(export())
        text = ctypes.string_at(memory)
        self.library.free(memory)
        return text

    def replace(self, text: bytes) -> None:
        """Make FFTW forget all wisdom of this precision and know this text instead.

        Also clears `made` and `version`.
        """
        self._read = b""
        self.version = None
        self.made.clear()
        self._function("forget_wisdom")()
        self._add(text)

    def _add(self, text: bytes) -> bool:
        """Add wisdom to that of this process; return whether FFTW accepted it."""
        return bool(self._function("import_wisdom_from_string")(text))

    def _function(self, name: str) -> Any:
        """Return a function of FFTW in this precision by its name without prefix."""
        return self.library[PREFIXES[self.name] + name]


_used: list[str] = []  # precisions


@cache
def _wisdom(name: str) -> _Wisdom:
    """Return the wisdom of this process in a precision, "float32" or "float64".

    The same object at every call; the first one adds the precision to `_used`.
    """
    _used.append(name)
    return _Wisdom(name)


def _lines(text: bytes) -> set[bytes]:
    """Split wisdom into its lines, each of which is a plan or a part of one."""
    return set(text.split(b"\n"))
