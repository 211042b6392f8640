"""FFTW's measured plans ("wisdom"): kept from run to run, the same on all ranks.

Equal plans round equally, and planning takes seconds: rank 0 plans with the user's cache and others
take over its wisdom. One file of bounded size for each library, kind of machine and precision; no
process waits, so of two runs that measure at once one may be lost.
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

LIMIT = 2**20  # bytes beyond which all is forgotten, and the file begun anew


def planned(comm: Comm, dtype: DTypeLike, make: Callable[[], T], shapes: Hashable) -> T:
    """Return make(), which plans by measurement, the same on all ranks. Collective. One process
    skips the cache for `shapes` it has made: writing all out takes longer than a known plan.
    """
    wisdom = _wisdom(np.dtype(dtype).name)
    if comm.size == 1 and shapes in wisdom.made:
        return make()
    wisdom.made.add(shapes)
    if comm.rank != 0:
        wisdom.replace(comm.bcast(None))
        return make()
    before = wisdom.read()
    plans = make()
    if launcher_rank() == 0:
        wisdom.write(before)
    comm.bcast(wisdom.text())
    return plans


class _Wisdom:
    """This process's wisdom in one precision; `made`: shapes planned."""

    def __init__(self, name: str):
        library_name, libraries = load_fftw()
        self.name = name
        self.library = libraries[name]
        self.made: set[Hashable] = set()
        # Wisdom begins with a line that tells version and instruction sets.
        first_line = self.text().split(b"\n", 1)[0]
        kind = library_name.encode() + first_line + processor().encode()
        self.kind = hashlib.sha256(kind).hexdigest()[:16]

    @property
    def path(self) -> Path | None:
        """The file in the cache for this kind of machine and precision; None without a cache."""
        folder = cache_folder()
        return folder and folder / "wisdom" / f"{self.kind}-{self.name}"

    def read(self) -> set[bytes]:
        """Add the wisdom in the cache to that of this process; return its lines, if accepted."""
        if len(self.text()) > LIMIT:
            self.replace(b"")
        content = (self.path and kept(self.path)) or b""
        is_good = len(content) <= LIMIT and self._function("import_wisdom_from_string")(content)
        return set(content.split(b"\n")) if is_good else set()

    def write(self, before: set[bytes]) -> None:
        """Write the wisdom of this process to the cache, if it has lines that were not there."""
        text = self.text()
        if self.path and not set(text.split(b"\n")) <= before:
            keep(self.path, text)

    def text(self) -> bytes:
        """Return all wisdom of this process as FFTW writes it; b"" from a library without any."""
        export = self._function("export_wisdom_to_string")
        export.restype = ctypes.c_void_p
        address = export()
        if not address:
            return b""
        text = ctypes.string_at(address)
        self.library.free(ctypes.c_void_p(address))
        return text

    def replace(self, text: bytes) -> None:
        """Make FFTW forget all wisdom of this precision and know this text instead."""
        self.made.clear()
        self._function("forget_wisdom")()
        self._function("import_wisdom_from_string")(text)

    def _function(self, name: str) -> Any:
        """Return a function of FFTW in this precision by its name without prefix."""
        return self.library[PREFIXES[self.name] + name]


_wisdom = cache(_Wisdom)  # the same object at every call
