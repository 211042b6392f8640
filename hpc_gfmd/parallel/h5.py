"""HDF5 files with fields of n_x times n_y points, spread over the ranks as slabs of rows.

Rank 0 takes the disk space of the whole file, since HDF5 does not survive a full disk, and creates
the datasets; then every rank writes its rows, by MPI-IO or through rank 0. A file grows by one more
such step (committed.py).
"""

import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from ..util.atomic import sync
from .comm import Comm, SerialComm
from .committed import reading
from .guard import collective_errors, on_rank_0

VERSIONS = ("v110", "v110")  # HDF5 1.10 and later read it, and its bookkeeping has checksums
# per rank and call: little extra memory, and far below the 2 GB where MPI-IO fails
PIECE_BYTES = 2**26
PACKED = {"shuffle": True, "compression": "gzip", "compression_opts": 1}
SLACK = 2**16  # bytes of everything but fields, generous: what is not needed is given back
_PER_CHUNK = 64  # bytes of HDF5's own for each row that is packed


@dataclass(eq=False)
class Stored:
    """A field (n_x, n_y) in a file, to be read by rows."""

    path: Path
    dataset: str
    shape: tuple[int, int]
    dtype: np.dtype

    def slab(self, comm: Comm, rows: tuple[int, int]) -> np.ndarray:
        """Return the rows (start, stop) of this rank as one array. Collective."""
        with collective_errors(comm, f"reading {self.path}"), reading(self.path) as file:
            numbers: np.ndarray = file[self.dataset][slice(*rows)]
        return numbers

    def read(self, start: int = 0, stop: int | None = None) -> np.ndarray:
        """Return the rows start <= i < stop, default all, on this rank alone."""
        return self.slab(SerialComm(), (start, self.shape[0] if stop is None else stop))


def write_file(
    comm: Comm,
    path: Path,
    n: tuple[int, int],
    rows: tuple[int, int],
    fields: Mapping[str, Any],
    describe: Callable[[Any], object] = lambda file: None,
    together: bool = False,
) -> None:
    """Write or replace one HDF5 file, all or nothing, by a .tmp file; describe(file) is called by
    rank 0 on empty datasets. Collective.
    """
    tmp = path.with_name(path.name + ".tmp")
    doing = f"writing {path}"
    shapes = {name: (n, np.dtype(field.dtype)) for name, field in fields.items()}
    try:
        on_rank_0(comm, doing, lambda: lay_out(tmp, shapes, describe))
        write_rows(comm, tmp, n, rows, fields, together, doing)
        on_rank_0(comm, doing, lambda: sync(tmp.replace(path).parent))
    except BaseException:  # Ctrl-C, too
        if comm.rank == 0:
            tmp.unlink(missing_ok=True)
        raise


def lay_out(
    path: Path,
    fields: Mapping[str, tuple[tuple[int, ...], np.dtype]],
    describe: Callable[[Any], object],
    compressed: bool = False,
    more: bool = False,
) -> None:
    """Write a file without the numbers of its fields, and take the disk space for all of it
    (OSError if the disk is full). One process calls it. describe(file) is called on empty datasets;
    `more` adds to a file that exists.
    """
    import h5py

    if not more:
        with h5py.File(path, "w", libver=VERSIONS, locking=False):
            pass
    space = SLACK
    for shape, dtype in fields.values():
        numbers = prod(shape) * dtype.itemsize
        space += numbers + compressed * (numbers // 500 + _PER_CHUNK * shape[0])
    with open(path, "r+b") as reserved:
        try:
            if hasattr(os, "posix_fallocate"):
                os.posix_fallocate(reserved.fileno(), os.fstat(reserved.fileno()).st_size, space)
        except OSError as error:
            raise OSError(error.errno, f"{error.strerror} ({space / 1e6:.4g} MB needed)") from None
    in_place = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    in_place.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    with h5py.File(path, "r+", libver=VERSIONS, locking=False) as file:
        for name, (shape, dtype) in fields.items():
            if name in file:  # of a run that is resumed
                continue
            options: dict = PACKED | {"chunks": (1, *shape[1:])} if compressed else {}
            if not compressed:
                options = {"dcpl": in_place.copy()}
            file.create_dataset(name, shape, dtype, fill_time="never", **options)
        describe(file)


def write_rows(
    comm: Comm,
    path: Path,
    n: tuple[int, int],
    rows: tuple[int, int],
    fields: Mapping[str, Any],
    together: bool,
    doing: str,
) -> None:
    """Write the rows (start, stop) of all ranks to a laid-out file, down to the disk. Collective.
    Fields: local slabs, or what reads rows as `Stored` does; `together`: by MPI-IO, else by rank 0.
    """
    together = together and comm.size > 1
    ranks_at_once = 1 if together else comm.size
    with _opened(comm, path, together, doing) as file:
        for name, field in fields.items():
            row_bytes = n[1] * np.dtype(field.dtype).itemsize * ranks_at_once
            for start, stop in _cuts(comm, rows, row_bytes):
                with collective_errors(comm, doing):
                    piece = _piece(field, start, stop, rows[0])
                    if piece.shape != (stop - start, n[1]) or stop > n[0]:
                        raise ValueError(
                            f"{piece.shape} points in rows {start}:{stop} of {tuple(n)}"
                        )
                mine = start, piece
                to_write = [mine] if together else comm.gather(mine) or ()
                with collective_errors(comm, doing):
                    for first_row, numbers in to_write:
                        if len(numbers):
                            file[name][first_row : first_row + len(numbers)] = numbers
                    sync(path, wait=False)
    with collective_errors(comm, doing):
        if comm.rank == 0 or together:
            sync(path)


def _piece(field: Any, start: int, stop: int, first_row: int) -> np.ndarray:
    """Return rows of a field that reads them, or of a local slab whose first row is `first_row`."""
    if hasattr(field, "read"):
        return field.read(start, stop)
    return np.ascontiguousarray(field[start - first_row : stop - first_row])


@contextmanager
def _opened(comm: Comm, path: Path, together: bool, doing: str) -> Iterator[Any]:
    """Open a laid-out file on all ranks (`together`) or on rank 0, else yield a context that does
    nothing; errors of the block are raised on all. Collective.
    """
    import h5py

    options = {"driver": "mpio", "comm": comm.mpi} if together else {"locking": False}
    file: Any = nullcontext()
    with collective_errors(comm, doing):
        os.stat(path)  # before ranks that see it wait for one that does not
    with collective_errors(comm, doing):
        if together or comm.rank == 0:
            file = h5py.File(path, "r+", libver=VERSIONS, **options)
    with collective_errors(comm, doing), file:
        yield file


def mpi_io_obstacle(comm: Comm, path: Path) -> str:
    """Return why the ranks cannot write a file by MPI-IO, "" if they can. Collective."""
    import h5py

    if comm.size == 1:
        return "one rank"
    if not h5py.get_config().mpi:
        return "h5py was built without MPI"
    if ":" in os.fspath(path):
        return "it takes what is before a colon for the kind of a file system"
    from mpi4py import MPI

    reason = ""
    try:
        file = MPI.File.Open(comm.mpi, os.fspath(path), MPI.MODE_RDWR)
    except MPI.Exception as error:
        reason = " ".join(error.Get_error_string().split()) or "unknown error"
    failing_rank = int(comm.min([comm.rank if reason else comm.size])[0])
    if failing_rank == comm.size:
        file.Close()  # together: a rank without it would not take part
        return ""
    return str(comm.bcast(reason, failing_rank))


def inside(group: Any, name: str) -> Any:
    """Return a member of a group; ValueError if it, or its numbers, lie in another file, as links,
    virtual and external datasets could name any file of the machine.
    """
    import h5py

    member = group[name]
    if member.file.filename != group.file.filename:
        raise ValueError(f"{name} is a link to another file")
    if isinstance(member, h5py.Dataset) and (member.is_virtual or member.external):
        raise ValueError(f"the numbers of {name} lie in another file")
    return member


def _cuts(comm: Comm, rows: tuple[int, int], row_bytes: int) -> list[tuple[int, int]]:
    """Cut this rank's rows into pieces up to PIECE_BYTES, as many on each rank. Collective."""
    step = max(1, PIECE_BYTES // row_bytes)
    count = int(comm.max([-((rows[0] - rows[1]) // step)])[0])
    return [
        (min(start, rows[1]), min(start + step, rows[1]))
        for start in range(rows[0], rows[0] + count * step, step)
    ]
