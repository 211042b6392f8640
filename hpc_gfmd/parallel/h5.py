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
from .mpi_io import io_way

VERSIONS = ("v110", "v110")  # HDF5 1.10 and later read it, and its bookkeeping has checksums
# attribute of a field; HDF5's own, Fletcher-32, needs chunks and is five times as slow as writing
CHECKSUM = "checksum"
# per rank and call: little extra memory, and far below the 2 GB where MPI-IO fails
PIECE_BYTES = 2**26
PACKED = {"shuffle": True, "compression": "gzip", "compression_opts": 1}
_SLACK, _PER_CHUNK = 2**16, 64  # bytes, generous; what is not needed is given back


@dataclass(eq=False)
class Stored:
    """A field in a file, to be read piece by piece.

    Attributes
    ----------
    path : Path
        The file.
    dataset : str
        Name of the field in it.
    shape : (int, int)
        (n_x, n_y) of the whole field.
    dtype : numpy.dtype
        Of its numbers.
    checksum : int
        Of all its numbers, as the file has it.
    passed : (int, int)
        Progress of the check, which `pieces` moves on: number of rows that have been read from the
        first one on without a gap, and their checksum.
    """

    path: Path
    dataset: str
    shape: tuple[int, int]
    dtype: np.dtype
    checksum: int
    passed: tuple[int, int] = 0, 0

    def pieces(
        self, comm: Comm | None = None, rows: tuple[int, int] | None = None, ranks_at_once: int = 1
    ) -> Iterator[tuple[int, np.ndarray]]:
        """Yield this rank's rows piece by piece, in as many pieces on every rank. Collective.

        Every rank must take all of its pieces, some of which may have no rows.

        Parameters
        ----------
        comm : Comm, optional
            The ranks that read; default: this process alone.
        rows : (int, int), optional
            (start, stop) of this rank; default: all.
        ranks_at_once : int
            Number of ranks whose pieces one rank holds at the same time; pieces are smaller by this
            factor.

        Yields
        ------
        int
            Number of the first row of a piece, in the whole field.
        ndarray
            The rows, shape (rows of the piece, n_y).

        Raises
        ------
        GfmdError
            On all ranks: if a rank cannot read; and after the last row, if all rows have been read
            in order (in one call or several) and the numbers do not match their checksum.
        """
        comm = comm or SerialComm()
        rows = rows or (0, self.shape[0])
        checksum = 0
        row_bytes = self.shape[1] * self.dtype.itemsize
        for start, stop in _cuts(comm, rows, row_bytes * ranks_at_once):
            with collective_errors(comm, f"reading {self.path}"), reading(self.path) as file:
                piece = file[self.dataset][start:stop]
                checksum += _checksum(piece, start)
            yield start, piece
        minus_begin, end = comm.max([-rows[0], rows[1]])  # of all ranks
        begin = -minus_begin
        rows_before, checksum_before = self.passed if begin else (0, 0)
        if rows_before == begin:  # otherwise it is no pass over all of them
            total = (checksum_before + _sum_modulo(comm, checksum)) % 2**64
            self.passed = int(end), total
            if end == self.shape[0] and total != self.checksum:
                raise GfmdError(f"{self.path}: the numbers of {self.dataset} are damaged")

    def slab(self, comm: Comm, rows: tuple[int, int]) -> np.ndarray:
        """Return this rank's rows as one array. Collective.

        Parameters
        ----------
        comm : Comm
            The ranks that read.
        rows : (int, int)
            (start, stop) of this rank.

        Returns
        -------
        ndarray, shape (stop - start, n_y)
            The rows.

        Raises
        ------
        GfmdError
            On all ranks, as `pieces` does, or if a rank lacks the memory.
        """
        with collective_errors(comm, f"reading {self.path}"):
            slab = np.empty((rows[1] - rows[0], self.shape[1]), self.dtype)
        for start, piece in self.pieces(comm, rows):
            slab[start - rows[0] : start - rows[0] + len(piece)] = piece
        return slab

    def read(self, start: int = 0, stop: int | None = None) -> np.ndarray:
        """Return some rows as one array. Not collective: every rank may read what it needs.

        Parameters
        ----------
        start, stop : int
            Rows start <= i < stop; default: all.

        Returns
        -------
        ndarray, shape (stop - start, n_y)
            The rows.

        Raises
        ------
        GfmdError
            As `pieces`.
        """
        return self.slab(SerialComm(), (start, self.shape[0] if stop is None else stop))


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
    """Write or replace one HDF5 file, all of it or nothing. Collective.

    Parameters
    ----------
    comm : Comm
        The ranks that have parts of the fields.
    path : Path
        The file; a file with .tmp appended to its name is written first.
    n : (int, int)
        (n_x, n_y) of all fields.
    rows : (int, int)
        (start, stop) of this rank, may be empty.
    fields : dict of ndarray or Stored
        Local slab of each dataset (any object with `dtype` and slices), or a field in another file;
        the same names on every rank.
    describe : function
        describe(file) is called by rank 0 when the datasets are there, still empty.
    compressed : bool
        Rows are chunks (so that none belongs to two ranks), shuffled and packed.
    dtype : str, optional
        Type of the numbers in the file; default: as they come.

    Returns
    -------
    dict of Stored
        The fields of the new file.

    Raises
    ------
    GfmdError
        On every rank when any of them fails: disk full, folder gone, field of a wrong shape, Stored
        one damaged.
    """
    tmp = path.with_name(path.name + ".tmp")
    doing = f"writing {path}"
    types = {name: np.dtype(dtype or field.dtype) for name, field in fields.items()}
    stored = {}

    def describe_all(file: Any) -> None:
        for name in fields:
            file[name].attrs.create(CHECKSUM, 0, dtype="uint64")
        describe(file)

    try:
        shapes = {name: (n, types[name]) for name in fields}
        on_rank_0(comm, doing, lambda: lay_out(tmp, shapes, describe_all, compressed))
        together = io_way(comm, tmp) == "mpio"
        ranks_at_once = 1 if together else comm.size
        with _opened(comm, tmp, together, doing) as file:
            for name, field in fields.items():
                checksum = 0
                for start, piece in _pieces(
                    comm, field, types[name], n, rows, ranks_at_once, doing
                ):
                    mine = start, piece
                    to_write = [mine] if together else comm.gather(mine) or ()
                    with collective_errors(comm, doing):
                        for first_row, numbers in to_write:
                            _write(file[name], first_row, numbers)
                            sync(tmp, wait=False)
                        checksum += _checksum(piece, start)
                total = _sum_modulo(comm, checksum)
                stored[name] = Stored(path, name, n, types[name], total)
                if together or comm.rank == 0:
                    file[name].attrs.modify(CHECKSUM, np.uint64(total))
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
    """Have the system write a file or folder to the disk; does nothing on Windows.

    Parameters
    ----------
    path : Path
        The file or folder.
    wait : bool
        True: return once it is on the disk. False: only have the system begin, so that the disk is
        busy while the next piece is made.
    """
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
def _opened(comm: Comm, path: Path, together: bool, doing: str) -> Iterator[Any]:
    """Open a laid-out file to fill in: on all ranks by MPI-IO if `together`, else on rank 0 alone.

    Yields the h5py file, or on ranks without it a context that does nothing, and closes it after
    the block. Errors, also those of the block, raise GfmdError on all ranks. Collective.
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


def reading(path: Path) -> Any:
    """Open an h5py file for reading, without locking it, and return it.

    So it can be read while it is written, or while it is open elsewhere in this process. The caller
    closes it. Raises OSError if it cannot be opened.
    """
    import h5py

    try:
        return h5py.File(path, "r", locking=False)
    except OSError as error:
        if "locking flag" not in str(error):
            raise
        return h5py.File(path, "r")


def inside(group: Any, name: str) -> Any:
    """Return a member of a group, which must be stored in the same file.

    Parameters
    ----------
    group : h5py.Group
        The group.
    name : str
        Name of the member.

    Returns
    -------
    h5py.Group or h5py.Dataset
        The member.

    Raises
    ------
    KeyError
        If there is no such member.
    ValueError
        If it, or its numbers, lie in another file: a link, a virtual or an external dataset could
        name any file of the machine.
    """
    import h5py

    member = group[name]
    if member.file.filename != group.file.filename:
        raise ValueError(f"{name} is a link to another file")
    if isinstance(member, h5py.Dataset) and (member.is_virtual or member.external):
        raise ValueError(f"the numbers of {name} lie in another file")
    return member


def lay_out(
    path: Path,
    fields: Mapping[str, tuple[tuple[int, ...], np.dtype]],
    describe: Callable[[Any], object],
    compressed: bool = False,
) -> None:
    """Write a file without the numbers of its fields, and take the disk space for all of it.

    Not collective: one process calls it.

    Parameters
    ----------
    path : Path
        The file; overwritten if it exists.
    fields : dict
        (shape, dtype) of each dataset.
    describe, compressed
        As for `write_file`.

    Raises
    ------
    OSError
        If the file cannot be written or the disk is full; the message has the space that is needed.
    """
    import h5py

    image = io.BytesIO()
    space = _SLACK * bool(fields)
    with h5py.File(image, "w", libver=VERSIONS) as file:
        for name, (shape, dtype) in fields.items():
            options = PACKED | {"chunks": (1, *shape[1:])} if compressed else {}
            file.create_dataset(name, shape, dtype, fill_time="never", **options)
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


def _pieces(
    comm: Comm,
    field: Any,
    dtype: np.dtype,
    n: tuple[int, int],
    rows: tuple[int, int],
    ranks_at_once: int,
    doing: str,
) -> Iterator[tuple[int, np.ndarray]]:
    """Yield (start, rows from there on) of this rank's part of a Stored field or a local slab.

    There are as many pieces on every rank, some of them perhaps empty. Raises GfmdError on all
    ranks if a slab of one has a wrong shape. Collective.
    """
    if isinstance(field, Stored):
        yield from field.pieces(comm, rows, ranks_at_once)
        return
    for start, stop in _cuts(comm, rows, n[1] * dtype.itemsize * ranks_at_once):
        with collective_errors(comm, doing):
            piece = np.ascontiguousarray(field[start - rows[0] : stop - rows[0]], dtype)
            if piece.shape != (stop - start, n[1]) or stop > n[0]:
                raise ValueError(f"{piece.shape} points in rows {start}:{stop} of {tuple(n)}")
        yield start, piece


def _cuts(comm: Comm, rows: tuple[int, int], row_bytes: int) -> list[tuple[int, int]]:
    """Cut this rank's rows into pieces (start, stop) of at most PIECE_BYTES, as many on every rank.

    A piece has at least one row, however long, but the last ones may be empty. row_bytes: bytes of
    memory that each row of a piece takes. Collective.
    """
    step = max(1, PIECE_BYTES // row_bytes)
    count = int(comm.max([-((rows[0] - rows[1]) // step)])[0])
    return [
        (min(start, rows[1]), min(start + step, rows[1]))
        for start in range(rows[0], rows[0] + count * step, step)
    ]


def _write(dataset: Any, start: int, rows: np.ndarray) -> None:
    """Write rows to a dataset from row `start` on. Collective if the file is open by MPI-IO.

    A rank without rows takes part, too; h5py's own way of writing leaves it out.
    """
    from h5py import h5fd, h5p, h5s

    memory = h5s.create_simple(rows.shape)
    space = dataset.id.get_space()
    transfer = h5p.create(h5p.DATASET_XFER)
    if dataset.file.driver == "mpio":
        transfer.set_dxpl_mpio(h5fd.MPIO_COLLECTIVE)
    space.select_hyperslab((start, 0), rows.shape)
    dataset.id.write(memory, space, rows, dxpl=transfer)


def _checksum(rows: np.ndarray, start: int) -> int:
    """Return the checksum of rows start, start + 1, ... of a field, which must be contiguous.

    The sum of the words of row i is multiplied by 2 i + 1. A word is an unsigned number of 8 bytes,
    or of 4 if that does not divide the row. Checksums add up over pieces and ranks, modulo 2**64.
    """
    words = rows.view("u8" if rows.shape[1] * rows.itemsize % 8 == 0 else "u4")
    return int(
        words.sum(axis=1, dtype=np.uint64)
        @ np.arange(2 * start + 1, 2 * (start + len(rows)), 2, dtype=np.uint64)
    )


def _sum_modulo(comm: Comm, checksum: int) -> int:
    """Return the sum of checksums over ranks modulo 2**64. Collective.

    Halves of 32 bits are summed, which float64 does exactly.
    """
    high, low = comm.sum(divmod(checksum % 2**64, 2**32))
    return (int(high) * 2**32 + int(low)) % 2**64
