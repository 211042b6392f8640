"""HDF5 files with two-dimensional fields that are spread over the ranks as slabs of rows: by collective MPI-IO where there are several.

A file is written in three moves: rank 0 lays out NAME.tmp (attributes, empty datasets, disk space taken), all ranks fill in their
rows, and once that is on the disk rank 0 renames it to NAME. Whatever dies in between, NAME is either the old file or the complete new
one. The space is taken first because HDF5 does not survive a full disk, and Open MPI was seen to report success on one.
"""

import errno
import io
import os
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..errors import GfmdError
from .guard import guarded
from .h5_sum import CHECKSUM, rows_sum, total

VERSIONS = ("v110", "v110")  # HDF5 1.10 and later read it, and its bookkeeping has checksums
PIECE_BYTES = 2**26  # per rank and call: little extra memory, and far below the 2 GB where MPI-IO fails
GZIP_LEVEL = 1
_PER_OBJECT, _PER_ROW, _BOOKKEEPING = 4096, 256, 2**20  # bytes, generous; what is not needed is given back


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
    checksum = None

    @property
    def stored(self) -> np.dtype:
        return np.dtype(self.dtype or self.data.dtype)

    @property
    def span(self) -> tuple[int, int]:
        return self.start, self.start + len(self.data)

    @contextmanager
    def reader(self, comm):
        """A function of (start, stop) that gives these global rows."""
        yield self.read

    def read(self, start: int, stop: int) -> np.ndarray:
        """These global rows, which must be among those of this rank."""
        return np.ascontiguousarray(self.data[start - self.start : stop - self.start], dtype=self.stored)


@dataclass(frozen=True)
class Stored:
    """A field in a file; span: the rows that this rank takes care of where all ranks read it; checksum: see h5_sum.py."""

    path: Path
    dataset: str
    shape: tuple[int, int]
    stored: np.dtype
    checksum: int | None = None
    span: tuple[int, int] = (0, 0)

    @contextmanager
    def reader(self, comm):
        """A function of (start, stop) that gives these rows; collective, with as many calls on every rank."""
        with opened(comm, self.path, "r", f"reading {self.path}") as file:
            def read(start, stop):
                rows = np.empty((stop - start, self.shape[1]), self.stored)
                _transfer(file, self.dataset, start, rows, "read")
                return rows

            yield read

    def read(self, start: int, stop: int) -> np.ndarray:
        """Global rows start <= i < stop as a (stop - start, m) array. Not collective."""
        return read_rows(self.path, self.dataset, (start, stop))


def read_rows(path, dataset: str, rows: tuple[int, int]) -> np.ndarray:
    """Rows start <= i < stop of a dataset. Not collective: every rank may read what it needs."""
    import h5py

    with h5py.File(path, "r", locking=False) as file:
        return file[dataset][rows[0] : rows[1]]


def read_slab(comm, field: Stored, rows: tuple[int, int]) -> np.ndarray:
    """This rank's rows of a field of which every row has one rank. Collective; raises GfmdError on all ranks if it is damaged."""
    slab = None
    with guarded(comm, f"reading {field.path}"):
        slab = np.empty((rows[1] - rows[0], field.shape[1]), field.stored)

    def keep(start, part):
        slab[start - rows[0] : start - rows[0] + len(part)] = part

    _pass_on(comm, replace(field, span=rows), keep, f"reading {field.path}")
    return slab


def io_way(comm, path, access=os.W_OK) -> str:
    """How a file is written (or read, os.R_OK): "mpio", or "serial" (one rank, HDF5 without MPI, a folder that only rank 0 sees)."""
    import h5py

    alone = comm.size == 1 or not h5py.get_config().mpi or not os.access(path, access)
    return "serial" if comm.max([alone])[0] else "mpio"


def write_file(comm, path, groups, fields, *, finish=None, compressed=False) -> None:
    """Write one HDF5 file, all of it or nothing. Collective.

    groups: {group: {attribute: value}}, used from rank 0; fields: {dataset: Slab or Stored}, the same names on every rank;
    finish(file): called by rank 0 when all but the numbers of the fields is there; compressed: shuffle and gzip.
    Raises GfmdError on every rank when any of them fails (disk full, folder gone, field of a wrong shape, Stored one damaged).
    """
    path = Path(path)
    tmp, doing = path.with_name(path.name + ".tmp"), f"writing {path}"
    _check(comm, fields, doing)
    try:
        with guarded(comm, doing):
            if comm.rank == 0:
                _lay_out(tmp, groups, fields, finish, compressed)
        if fields:
            with opened(comm, tmp, "r+", doing) as file:
                for name, field in fields.items():
                    checksum = _pass_on(comm, field, lambda start, rows, name=name: _put(comm, file, name, start, rows), doing)
                    with guarded(comm, doing):
                        if file is not None:
                            file[name].attrs.modify(CHECKSUM, checksum)
        with guarded(comm, doing):
            if comm.rank == 0 or os.access(tmp, os.R_OK):
                sync(tmp)
        with guarded(comm, doing):
            if comm.rank == 0:
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


@contextmanager
def opened(comm, path, mode, doing):
    """An h5py file on all ranks, by MPI-IO where that is possible; None where rank 0 alone can write. Collective."""
    import h5py

    way = io_way(comm, path, os.R_OK if mode == "r" else os.W_OK)
    how = {"driver": "mpio", "comm": comm.mpi} if way == "mpio" else {"locking": False}
    file = None
    with guarded(comm, doing):
        if way == "mpio" or comm.rank == 0 or mode == "r":
            file = h5py.File(path, mode, libver=VERSIONS, **how)
    try:
        yield file
    except GfmdError:  # all ranks are here
        if file is not None:
            file.close()
        raise
    with guarded(comm, doing):
        if file is not None:
            file.close()


def _pass_on(comm, field, take, doing) -> int:
    """This rank's rows, piece by piece, to take(start, rows), as often on every rank; returns the checksum of the whole field.

    A rank that fails takes part in the collective calls, without rows, and then all stop: leaving alone would hang the others.
    """
    first, last = field.span
    step = max(1, PIECE_BYTES // (field.shape[1] * field.stored.itemsize))
    own, found = range(first, last, step), 0
    with field.reader(comm) as read:
        for call in range(int(comm.max([len(own)])[0])):
            start, rows, failed = own[call] if call < len(own) else last, np.empty((0, field.shape[1]), field.stored), None
            with guarded(comm, doing):
                try:
                    rows = read(start, min(start + step, last))
                    found += rows_sum(rows, start)
                except Exception as error:
                    failed = error
                take(start, rows)
                if failed is not None:
                    raise failed
    found = total(comm, found)
    if isinstance(field, Stored) and found != field.checksum:
        raise GfmdError(f"{field.path}: the numbers of {field.dataset} are damaged")
    return found


def _put(comm, file, name, start, rows) -> None:
    """Rows of this rank, or none, into the file: by all ranks together, or through rank 0, the only one that has it open."""
    if comm.size == 1 or comm.allgather(file is None).count(True) == 0:
        _transfer(file, name, start, rows, "write")
        return
    errors = []
    for owner in range(comm.size):
        if comm.rank == 0:
            start, rows = (start, rows) if owner == 0 else comm.mpi.recv(source=owner)
            try:
                _transfer(file, name, start, rows, "write")
            except Exception as error:  # goes on receiving: the others would wait
                errors.append(error)
        elif comm.rank == owner:
            comm.mpi.send((start, rows), dest=0)
    if errors:
        raise errors[0]


def _transfer(file, name, start, rows, what) -> None:
    """HDF5's "read" or "write", collective by MPI-IO; low-level because h5py's own leaves out ranks without rows."""
    from h5py import h5fd, h5p, h5s

    dataset = file[name].id
    memory, space, how = h5s.create_simple(rows.shape), dataset.get_space(), h5p.create(h5p.DATASET_XFER)
    if file.driver == "mpio":
        how.set_dxpl_mpio(h5fd.MPIO_COLLECTIVE)
    if len(rows):
        space.select_hyperslab((start, 0), rows.shape)
    else:
        memory.select_none()
        space.select_none()
    getattr(dataset, what)(memory, space, rows, dxpl=how)


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


def _lay_out(path, groups, fields, finish, compressed) -> None:
    """The file without the numbers of the fields, and the disk space for all of it. One process only."""
    import h5py

    numbers = sum(field.shape[0] * field.shape[1] * field.stored.itemsize + _PER_ROW * sum(field.shape) for field in fields.values())
    objects = sum(4 * len(str(attributes)) + _PER_OBJECT for attributes in groups.values()) + 4 * _PER_OBJECT * len(fields)
    space = numbers + numbers // 500 * compressed + objects + _BOOKKEEPING
    empty = io.BytesIO()
    h5py.File(empty, "w", libver=VERSIONS).close()
    Path(path).write_bytes(empty.getvalue())  # opened below rather than cut to length 0 by HDF5
    _reserve(path, space)
    with h5py.File(path, "r+", locking=False, libver=VERSIONS) as file:
        for name, attributes in groups.items():
            file.require_group(name).attrs.update(attributes)
        for name, field in fields.items():
            _create_dataset(file, name, field, compressed)
        if finish is not None:
            finish(file)
    if compressed and fields:
        _reserve(path, space)  # closing gave the unused part back


def _reserve(path, size) -> None:
    """Lengthen a file to `size` bytes that are sure to be there; raises GfmdError if the disk is full or a quota reached."""
    with open(path, "r+b") as file:
        try:
            os.posix_fallocate(file.fileno(), 0, size)
        except OSError as error:
            if error.errno not in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
                raise
            raise GfmdError(f"{error.strerror} ({size / 1e6:.4g} MB needed)") from None


def _create_dataset(file, name, field, compressed) -> None:
    """Chunks are rows, so that none belongs to two ranks."""
    from h5py import h5d, h5p, h5s, h5t

    layout = h5p.create(h5p.DATASET_CREATE)
    layout.set_fill_time(h5d.FILL_TIME_NEVER)
    if compressed:
        layout.set_chunk((1, field.shape[1]))
        layout.set_shuffle()
        layout.set_deflate(GZIP_LEVEL)
    else:
        layout.set_alloc_time(h5d.ALLOC_TIME_EARLY)
    parent, _, last = name.rpartition("/")
    group = file.require_group(parent or "/")
    h5d.create(group.id, last.encode(), h5t.py_create(field.stored, logical=True), h5s.create_simple(field.shape), layout)
    group[last].attrs.create(CHECKSUM, 0, dtype="int64")
