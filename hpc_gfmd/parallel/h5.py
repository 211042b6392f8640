"""HDF5 files with two-dimensional fields that are spread over the ranks as slabs of rows.

A file is written in three moves: rank 0 lays out a form NAME.tmp (attributes, empty datasets, disk space
reserved), all ranks fill in their rows, and once that is on the disk rank 0 renames it to NAME. Whatever dies
in between, NAME is either the old file or the complete new one.
"""

import os
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..errors import GfmdError
from . import h5_fill, h5_layout, h5_seal
from .guard import guarded
from .h5_sum import Summed, total


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
    """A field in a file; `span` are the rows this rank takes care of when the field is copied; checksum: see h5_sum, or None."""

    path: Path
    dataset: str
    shape: tuple[int, int]
    stored: np.dtype
    compressed: bool = False
    span: tuple[int, int] = (0, 0)
    checksum: int | None = None

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
    fields: {dataset: Slab or Stored}, the same names on every rank; copies: {dataset: Stored}, copied by rank 0
    as they are, compression included; compressed: shuffle and gzip; transport: "direct", "root" or "mpio", see
    h5_fill (default: the best).
    Raises GfmdError on every rank when any of them fails (disk full, folder gone, field of a wrong shape, Stored one damaged).
    """
    path = Path(path)
    tmp = path.with_name(path.name + ".tmp")
    doing = f"writing {path}"
    offsets = None
    _check(comm, fields, doing)
    try:
        with guarded(comm, doing):
            if comm.rank == 0:
                offsets = h5_layout.lay_out(tmp, groups, fields, copies or {}, compressed)
        if fields:
            summed = {name: Summed(field) for name, field in fields.items()}
            h5_fill.fill(comm, tmp, summed, comm.bcast(offsets), doing, transport)
            sums = dict(zip(fields, total(comm, [field.sum for field in summed.values()])))
            with guarded(comm, doing):
                _compare(fields, sums)
                if comm.rank == 0:
                    h5_layout.write_sums(tmp, sums)
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


def intact(comm, fields) -> bool:
    """Whether the numbers of Stored fields are what was written. Collective: each rank reads its share."""
    sums, failed = [], False
    for field in fields:
        n_x = field.shape[0]
        own = Summed(replace(field, span=(n_x * comm.rank // comm.size, n_x * (comm.rank + 1) // comm.size)))
        try:
            for start, stop in h5_fill.pieces(own):
                own.read(start, stop)
        except Exception:
            failed = True
        sums.append(own.sum)
    if comm.max([failed])[0]:
        return False
    return all(field.checksum in (None, found) for field, found in zip(fields, total(comm, sums)))


def _compare(fields, sums) -> None:
    for name, field in fields.items():
        if isinstance(field, Stored) and field.checksum not in (None, sums[name]):
            raise GfmdError(f"the numbers of {field.dataset} in {field.path} have been damaged: remove that file and restart")


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


