"""HDF5 files with two-dimensional fields that are spread over the ranks as slabs of rows.

A file is written in three moves: rank 0 lays out a form NAME.tmp (attributes, empty datasets, disk space
reserved), all ranks fill in their rows, and once that is on the disk rank 0 renames it to NAME. Whatever dies
in between, NAME is either the old file or the complete new one.
"""

import ctypes
import errno
import json
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import GfmdError
from . import h5_fill, h5_seal
from .guard import guarded

FORMAT = "hpc-gfmd"
FORMAT_VERSION = 1
# HDF5 1.10 and later read it, and unlike the oldest layout it has checksums on most of the bookkeeping
_LAYOUT = ("v110", "v110")


@dataclass(frozen=True)
class Slab:
    """The rows of a field that live in this rank's memory.

    data: (local rows, m), may be empty; start: global index of its first row; shape: global (rows, m);
    dtype: as stored (default: that of data).
    """

    data: np.ndarray
    start: int
    shape: tuple[int, int]
    dtype: np.dtype | str | None = None

    @property
    def stored(self) -> np.dtype:
        return np.dtype(self.dtype or self.data.dtype)

    @property
    def span(self) -> tuple[int, int]:
        return self.start, self.start + len(self.data)

    def read(self, start: int, stop: int) -> np.ndarray:
        return np.ascontiguousarray(self.data[start - self.start : stop - self.start], dtype=self.stored)


@dataclass(frozen=True)
class Stored:
    """A field in a file; `span` are the rows this rank takes care of when the field is copied."""

    path: Path
    dataset: str
    shape: tuple[int, int]
    stored: np.dtype
    compressed: bool = False
    span: tuple[int, int] = (0, 0)

    def read(self, start: int, stop: int) -> np.ndarray:
        """Global rows start <= i < stop as a (stop - start, m) array."""
        return read_rows(self.path, self.dataset, (start, stop))


def read_rows(path, dataset: str, rows: tuple[int, int]) -> np.ndarray:
    """Rows start <= i < stop of a dataset. Not collective: every rank may read what it needs."""
    import h5py

    with h5py.File(path, "r", locking=False) as file:
        return file[dataset][rows[0] : rows[1]]


def write_file(comm, path, groups, fields, *, copies=None, compressed=False, transport=None) -> None:
    """Write one HDF5 file, all of it or nothing. Collective.

    groups: {group: {attribute: value}}, used from rank 0; the root's format and format_version are added;
    fields: {dataset: Slab or Stored}, the same names on every rank; copies: {dataset: Stored}, copied by rank 0 as they are, compression included;
    compressed: shuffle and gzip; transport: "direct", "root" or "mpio", see h5_fill (default: the best).
    Raises GfmdError on every rank when any of them fails (disk full, folder gone, field of a wrong shape).
    """
    path = Path(path)
    tmp = path.with_name(path.name + ".tmp")
    doing = f"writing {path}"
    offsets = None
    _check(comm, fields, doing)
    try:
        with guarded(comm, doing):
            if comm.rank == 0:
                offsets = _lay_out(tmp, groups, fields, copies or {}, compressed)
                _reserve(tmp)
        if fields:
            h5_fill.fill(comm, tmp, fields, comm.bcast(offsets), doing, transport)
        with guarded(comm, doing):
            if comm.rank == 0:
                h5_seal.seal(tmp)
                sync(tmp)
                os.replace(tmp, path)
                sync(path.parent)
    except GfmdError:
        if comm.rank == 0:
            tmp.unlink(missing_ok=True)
        raise


def sync(path) -> None:
    """Ask the system to bring a file or folder to the disk."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _check(comm, fields, doing) -> None:
    with guarded(comm, doing):
        for name, field in fields.items():
            start, stop = field.span
            if not 0 <= start <= stop <= field.shape[0]:
                raise GfmdError(f"field {name}: rows {start}:{stop} are outside its shape {field.shape}")
            if isinstance(field, Slab) and (field.data.ndim != 2 or field.data.shape[1] != field.shape[1]):
                raise GfmdError(f"field {name}: local shape {field.data.shape} does not fit {field.shape}")
    layouts = comm.allgather([(name, tuple(field.shape), field.stored.str) for name, field in fields.items()])
    with guarded(comm, doing):
        if any(other != layouts[0] for other in layouts):
            raise GfmdError("the ranks disagree about the names, shapes or types of the fields")


def _lay_out(tmp, groups, fields, copies, compressed) -> dict[str, int | None]:
    """Everything but the fields' numbers; returns where in the file those go, None for compressed ones."""
    import h5py

    with h5py.File(tmp, "w", locking=False, libver=_LAYOUT, userblock_size=h5_seal.BLOCK) as file:
        file.attrs.update(format=FORMAT, format_version=FORMAT_VERSION)
        for name, attributes in groups.items():
            group = file.require_group(name)
            for key, value in attributes.items():
                if value is not None:
                    group.attrs[key] = json.dumps(value) if isinstance(value, dict) else value
        offsets = {name: _create_dataset(file, name, field, compressed) for name, field in fields.items()}
        for name, stored in copies.items():
            with h5py.File(stored.path, "r", locking=False) as source:
                parent, _, last = name.rpartition("/")
                source.copy(stored.dataset, file.require_group(parent or "/"), name=last)
    return offsets


def _create_dataset(file, name, field, compressed) -> int | None:
    from h5py import h5d, h5p, h5s, h5t

    layout = h5p.create(h5p.DATASET_CREATE)
    layout.set_fill_time(h5d.FILL_TIME_NEVER)
    if compressed:
        layout.set_chunk((1, field.shape[1]))  # a chunk never belongs to two ranks
        layout.set_shuffle()
        layout.set_deflate(h5_fill.GZIP_LEVEL)
    else:
        layout.set_alloc_time(h5d.ALLOC_TIME_EARLY)
    parent, _, last = name.rpartition("/")
    group = file.require_group(parent or "/")
    kind = h5t.py_create(field.stored, logical=True)
    dataset = h5d.create(group.id, last.encode(), kind, h5s.create_simple(field.shape), layout)
    return None if compressed else dataset.get_offset()


def _reserve(path) -> None:
    """Take the disk space now, while only one rank can fail; skipped where the file system cannot do it."""
    libc = ctypes.CDLL(None, use_errno=True)
    fallocate = getattr(libc, "fallocate64", None) or getattr(libc, "fallocate", None)
    size = os.path.getsize(path)
    if fallocate is None or size == 0:
        return
    fallocate.argtypes = (ctypes.c_int, ctypes.c_int, ctypes.c_int64, ctypes.c_int64)
    with open(path, "r+b") as file:
        failed = ctypes.get_errno() if fallocate(file.fileno(), 0, 0, size) else 0
    if failed in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
        raise GfmdError(f"{os.strerror(failed)} ({size / 1e9:.3g} GB needed)")
