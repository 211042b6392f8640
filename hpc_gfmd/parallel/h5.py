"""HDF5 files with fields of n_x times n_y points that are spread over the ranks as slabs of rows,
written by MPI-IO where there are several.

A file is written in three moves: rank 0 puts its layout (attributes, empty datasets), made in
memory, into NAME.tmp and takes the disk space for all of it; all ranks fill in their rows; once
that is on the disk rank 0 renames it to NAME. Whatever dies in between, NAME is either the old file
or the complete new one. The space is taken first because HDF5 does not survive a full disk, and
Open MPI was seen to report success on one.
"""

import io
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from ..util.errors import GfmdError
from .comm import Comm, SerialComm
from .guard import collective_errors, on_rank_0

VERSIONS = ("v110", "v110")  # HDF5 1.10 and later read it, and its bookkeeping has checksums
# attribute of a field; HDF5's own, Fletcher-32, needs chunks and is five times as slow as writing
CHECKSUM = "checksum"
# per rank and call: little extra memory, and far below the 2 GB where MPI-IO fails
PIECE_BYTES = 2**26
PACKED = {"shuffle": True, "compression": "gzip", "compression_opts": 1}
_SLACK, _PER_CHUNK = 2**16, 64  # bytes, generous; what is not needed is given back


@dataclass(eq=False)
class Stored:
    """A field in a file; shape: (n_x, n_y); checksum: of all its numbers."""

    path: Path
    dataset: str
    shape: tuple[int, int]
    dtype: np.dtype
    checksum: int
    # how many rows were read one after the other from the first on, and their checksum
    passed: tuple[int, int] = 0, 0

    def pieces(
        self, comm: Comm | None = None, rows: tuple[int, int] | None = None
    ) -> Iterator[tuple[int, np.ndarray]]:
        """Yield (start, rows from there on), ... as many on every rank; rows: (start, stop) of this
        one (default: all of one process). Collective; raises GfmdError, for damaged numbers after
        the last row of a pass over all of them, in one call or several."""
        comm, rows = comm or SerialComm(), rows or (0, self.shape[0])
        found, doing = 0, f"reading {self.path}"
        for start, stop in _cuts(comm, rows, self.shape[1] * self.dtype.itemsize):
            with collective_errors(comm, doing), reading(self.path) as file:
                part = file[self.dataset][start:stop]
                found += _checksum(part, start)
            yield start, part
        begin, end = comm.max([-rows[0], rows[1]])  # of all ranks
        before, known = self.passed if begin else (0, 0)
        if before == -begin:  # otherwise it is no pass over all of them
            self.passed = int(end), (known + _total(comm, found)) % 2**64
            if end == self.shape[0] and self.passed[1] != self.checksum:
                raise GfmdError(f"{self.path}: the numbers of {self.dataset} are damaged")

    def slab(self, comm: Comm, rows: tuple[int, int]) -> np.ndarray:
        """Read this rank's rows (start, stop) in one array. Collective; raises GfmdError as
        `pieces`."""
        with collective_errors(comm, f"reading {self.path}"):
            found = np.empty((rows[1] - rows[0], self.shape[1]), self.dtype)
        for start, part in self.pieces(comm, rows):
            found[start - rows[0] : start - rows[0] + len(part)] = part
        return found

    def read(self, start: int = 0, stop: int | None = None) -> np.ndarray:
        """Read rows start <= i < stop. Not collective: every rank may read what it needs. Raises
        GfmdError as `pieces`."""
        return self.slab(SerialComm(), (start, self.shape[0] if stop is None else stop))


def io_way(comm: Comm) -> str:
    """Tell how fields are written: "mpio", where opening and closing are collective, on several
    ranks if HDF5 has it, or "serial"."""
    import h5py

    return "mpio" if comm.size > 1 and h5py.get_config().mpi else "serial"


def write_file(
    comm: Comm,
    path: Path,
    n: tuple[int, int],
    rows: tuple[int, int],
    fields: Mapping[str, Any],
    describe: Callable = lambda file: None,
    compressed: bool = False,
    dtype: str | None = None,
) -> dict[str, Stored]:
    """Write one HDF5 file, all of it or nothing; returns its fields. Collective.

    n: (n_x, n_y); rows: (start, stop) of this rank, may be empty; fields: {dataset: local slab,
    which is only sliced, or Stored}, with the same names on every rank; describe(file): called by
    rank 0 when the datasets are there, still empty; compressed: rows are chunks (so that none
    belongs to two ranks), shuffled and packed; dtype: as stored (default: as they come). Raises
    GfmdError on every rank when any of them fails (disk full, folder gone, field of a wrong shape,
    Stored one damaged).
    """
    tmp, doing = path.with_name(path.name + ".tmp"), f"writing {path}"
    together = io_way(comm) == "mpio"
    types, stored = {name: np.dtype(dtype or field.dtype) for name, field in fields.items()}, {}

    def described(file: Any) -> None:
        for name in fields:
            file[name].attrs.create(CHECKSUM, 0, dtype="uint64")
        describe(file)

    try:
        shapes = {name: (n, types[name]) for name in fields}
        on_rank_0(comm, doing, lambda: lay_out(tmp, shapes, described, compressed))
        with _opened(comm, tmp, doing) as file:
            for name, field in fields.items():
                found = 0
                for start, part in _parts(comm, field, types[name], n, rows, doing):
                    parts = [(start, part)] if together else comm.gather((start, part)) or ()
                    with collective_errors(comm, doing):
                        for at, numbers in parts:
                            _write(file[name], at, numbers)
                            sync(tmp, wait=False)
                        found += _checksum(part, start)
                stored[name] = Stored(path, name, n, types[name], _total(comm, found))
                if together or comm.rank == 0:
                    file[name].attrs.modify(CHECKSUM, np.uint64(stored[name].checksum))
        with collective_errors(comm, doing):
            if comm.rank == 0 or together:
                sync(tmp)
        on_rank_0(comm, doing, lambda: sync(tmp.replace(path).parent))
    except BaseException:  # Ctrl-C, too
        if comm.rank == 0:
            tmp.unlink(missing_ok=True)
        raise
    return stored


def sync(path: Path, wait: bool = True) -> None:
    """Bring a file or folder to the disk, or have the system begin to: the disk is busy then while
    the next piece is made."""
    if os.name == "nt":  # no descriptor of a folder
        return
    descriptor = os.open(path, os.O_RDONLY)
    try:
        if wait:
            os.fsync(descriptor)
        elif hasattr(os, "posix_fadvise"):
            os.posix_fadvise(descriptor, 0, 0, os.POSIX_FADV_DONTNEED)
    finally:
        os.close(descriptor)


@contextmanager
def _opened(comm: Comm, path: Path, doing: str) -> Iterator[Any]:
    """Open an h5py file to fill in: by MPI-IO where it can be, else rank 0's alone. Collective."""
    import h5py

    together = io_way(comm) == "mpio"
    how = {"driver": "mpio", "comm": comm.mpi} if together else {"locking": False}
    file: Any = nullcontext()
    with collective_errors(comm, doing):
        os.stat(path)  # before ranks that see it wait for one that does not
    with collective_errors(comm, doing):
        if together or comm.rank == 0:
            file = h5py.File(path, "r+", libver=VERSIONS, **how)
    with collective_errors(comm, doing), file:
        yield file


def reading(path: Path) -> Any:
    """Open an h5py file to read, also while it is written, or open elsewhere in this process."""
    import h5py

    try:
        return h5py.File(path, "r", locking=False)
    except OSError as error:
        if "locking flag" not in str(error):
            raise
        return h5py.File(path, "r")


def inside(group: Any, name: str) -> Any:
    """Find the group or dataset `name`. Raises ValueError if it, or its numbers, lie in another
    file: a link, a virtual or an external dataset could name any one of the machine."""
    import h5py

    found = group[name]
    if found.file.filename != group.file.filename:
        raise ValueError(f"{name} is a link to another file")
    if isinstance(found, h5py.Dataset) and (found.is_virtual or found.external):
        raise ValueError(f"the numbers of {name} lie in another file")
    return found


def lay_out(
    path: Path,
    fields: Mapping[str, tuple[tuple[int, ...], np.dtype]],
    describe: Callable[[Any], object],
    compressed: bool = False,
) -> None:
    """Write a file without the numbers of its fields, {dataset: (shape, dtype)}, and take the disk
    space for all of it. describe, compressed: as of write_file. One process only."""
    import h5py

    image, space = io.BytesIO(), _SLACK * bool(fields)
    with h5py.File(image, "w", libver=VERSIONS) as file:
        for name, (shape, dtype) in fields.items():
            how = PACKED | {"chunks": (1, *shape[1:])} if compressed else {}
            file.create_dataset(name, shape, dtype, fill_time="never", **how)
            numbers = prod(shape) * dtype.itemsize
            space += numbers + compressed * (numbers // 500 + _PER_CHUNK * shape[0])
        describe(file)
    space += image.getbuffer().nbytes
    with open(path, "wb") as file:
        try:
            if hasattr(os, "posix_fallocate"):
                os.posix_fallocate(file.fileno(), 0, space)
            file.write(image.getbuffer())
            file.flush()
        except OSError as error:
            raise OSError(error.errno, f"{error.strerror} ({space / 1e6:.4g} MB needed)") from None


def _parts(
    comm: Comm, field: Any, dtype: np.dtype, n: tuple[int, int], rows: tuple[int, int], doing: str
) -> Iterator[tuple[int, np.ndarray]]:
    """Yield (start, rows from there on), ... of a Stored field or a local slab."""
    if isinstance(field, Stored):
        yield from field.pieces(comm, rows)
        return
    for start, stop in _cuts(comm, rows, n[1] * dtype.itemsize):
        with collective_errors(comm, doing):
            part = np.ascontiguousarray(field[start - rows[0] : stop - rows[0]], dtype)
            if part.shape != (stop - start, n[1]) or stop > n[0]:
                raise ValueError(f"{part.shape} points in rows {start}:{stop} of {tuple(n)}")
        yield start, part


def _cuts(comm: Comm, rows: tuple[int, int], row_bytes: int) -> list[tuple[int, int]]:
    """Return (start, stop) of pieces of this rank's rows, as many on every rank."""
    ranks = comm.size if io_way(comm) == "serial" else 1  # of which rank 0 has a piece each
    step = max(1, PIECE_BYTES // (row_bytes * ranks))
    calls = int(comm.max([-((rows[0] - rows[1]) // step)])[0])
    return [
        (min(i, rows[1]), min(i + step, rows[1]))
        for i in range(rows[0], rows[0] + calls * step, step)
    ]


def _write(dataset: Any, start: int, rows: np.ndarray) -> None:
    """Write rows, together with all ranks by MPI-IO; low-level because h5py's own leaves out ranks
    without rows."""
    from h5py import h5fd, h5p, h5s

    memory, space = h5s.create_simple(rows.shape), dataset.id.get_space()
    how = h5p.create(h5p.DATASET_XFER)
    if dataset.file.driver == "mpio":
        how.set_dxpl_mpio(h5fd.MPIO_COLLECTIVE)
    space.select_hyperslab((start, 0), rows.shape)
    dataset.id.write(memory, space, rows, dxpl=how)


def _checksum(rows: np.ndarray, start: int) -> int:
    """Add up rows start, start + 1, ...: the sum of their words, times an odd number of the row;
    adds up over pieces and ranks."""
    words = rows.view("u8" if rows.shape[1] * rows.itemsize % 8 == 0 else "u4")
    return int(
        words.sum(axis=1, dtype=np.uint64)
        @ np.arange(2 * start + 1, 2 * (start + len(rows)), 2, dtype=np.uint64)
    )


def _total(comm: Comm, checksum: int) -> int:
    """Sum over ranks modulo 2**64; as halves, which float64 adds exactly."""
    high, low = comm.sum(divmod(checksum % 2**64, 2**32))
    return (int(high) * 2**32 + int(low)) % 2**64
