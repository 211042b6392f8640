"""How the numbers of fields get from all ranks into the datasets of an HDF5 file that is already laid out.

direct  every rank writes its rows at their place in the file; the fastest, and no error goes unreported
root    rank 0 receives and writes the rows: for compressed fields (each rank compresses its own rows), and
        for folders that only rank 0 can see
mpio    collective MPI-IO of a parallel HDF5, on request: Open MPI 4.1 was seen to report success when the
        disk was full, so what it wrote is read back and compared
"""

import os
import zlib

import numpy as np

from ..errors import GfmdError
from .guard import guarded

PIECE_BYTES = 2**26  # per rank and call: little extra memory, and far below the 2 GB where MPI-IO fails
GZIP_LEVEL = 1
TRANSPORTS = ("direct", "root", "mpio")


def fill(comm, path, fields, offsets, doing, transport=None) -> None:
    """Write all fields and bring them to the disk. Collective; raises GfmdError on every rank.

    offsets: {name: position in the file of a contiguous dataset, None for a compressed one}.
    """
    compressed = {name: field for name, field in fields.items() if offsets[name] is None}
    plain = {name: field for name, field in fields.items() if offsets[name] is not None}
    with guarded(comm, doing):
        if transport not in (None, *TRANSPORTS):
            raise GfmdError(f"transport: found {transport!r}, allowed: {', '.join(TRANSPORTS)}")
    if plain and transport == "mpio":
        _fill_by_mpio(comm, path, plain, doing)
    elif plain and transport != "root" and _seen_by_all(comm, path):
        _fill_directly(comm, path, plain, offsets, doing)
    elif plain:
        _fill_through_root(comm, path, plain, doing, _rows, _put_rows)
    if compressed:
        _fill_through_root(comm, path, compressed, doing, _packed_rows, _put_packed_rows)


def pieces(field) -> list[tuple[int, int]]:
    """This rank's rows in pieces of at most PIECE_BYTES."""
    start, stop = field.span
    step = max(1, PIECE_BYTES // (field.shape[1] * field.stored.itemsize))
    return [(row, min(row + step, stop)) for row in range(start, stop, step)]


def _seen_by_all(comm, path) -> bool:
    return not comm.max([not os.access(path, os.W_OK)])[0]


def _fill_directly(comm, path, fields, offsets, doing) -> None:
    with guarded(comm, doing), open(path, "r+b", buffering=0, opener=_for_writing_only) as file:
        for name, field in fields.items():
            row_bytes = field.shape[1] * field.stored.itemsize
            for start, stop in pieces(field):
                left = memoryview(field.read(start, stop).reshape(-1).view(np.uint8))
                position = offsets[name] + start * row_bytes
                while left:
                    written = os.pwrite(file.fileno(), left, position)
                    left, position = left[written:], position + written
        os.fsync(file.fileno())


def _for_writing_only(path, _):
    """Network file systems would read pages that two ranks share before writing their part of them."""
    return os.open(path, os.O_WRONLY)


def _rows(field, start, stop):
    return field.read(start, stop)


def _put_rows(dataset, start, rows):
    dataset[start : start + len(rows)] = rows


def _packed_rows(field, start, stop):
    """Each row as HDF5's shuffle and deflate filters would leave it."""
    rows = field.read(start, stop)
    shuffled = rows.view(np.uint8).reshape(len(rows), -1, rows.itemsize).swapaxes(1, 2)
    return [zlib.compress(row.tobytes(), GZIP_LEVEL) for row in shuffled]


def _put_packed_rows(dataset, start, rows):
    for row, packed in enumerate(rows, start):
        dataset.id.write_direct_chunk((row, 0), packed)


def _fill_through_root(comm, path, fields, doing, make, put) -> None:
    """After an error the owner sends it instead of rows, and rank 0 still receives: nobody waits for ever."""
    import h5py

    file = None
    errors = []
    with guarded(comm, doing):
        if comm.rank == 0:
            file = h5py.File(path, "r+", locking=False)
    for name, field in fields.items():
        for owner, owned in enumerate(comm.allgather(pieces(field))):
            for piece in owned if comm.rank in (0, owner) else ():
                rows = None
                if comm.rank == owner:
                    rows = _or_error(make, field, *piece)
                if owner != 0:
                    rows = comm.mpi.recv(source=owner) if comm.rank == 0 else comm.mpi.send(rows, dest=0)
                if comm.rank == 0:
                    failed = rows if isinstance(rows, Exception) else None
                    if not errors and failed is None:
                        failed = _or_error(put, file[name], piece[0], rows)
                    errors += [failed] if failed else []
    with guarded(comm, doing):
        if file is not None:
            try:
                file.close()
            finally:
                if errors:
                    raise errors[0]


def _or_error(function, *args):
    try:
        return function(*args)
    except Exception as error:
        return error


def _fill_by_mpio(comm, path, fields, doing) -> None:
    """A rank that fails goes on with empty pieces: leaving the collective calls would hang the others."""
    import h5py
    from h5py import h5fd, h5p

    with guarded(comm, doing):
        if not h5py.get_config().mpi or comm.mpi is None:
            raise GfmdError("transport mpio needs h5py built with MPI, and an MPI launcher")
    with guarded(comm, doing):
        file = h5py.File(path, "r+", driver="mpio", comm=comm.mpi)
    collective = h5p.create(h5p.DATASET_XFER)
    collective.set_dxpl_mpio(h5fd.MPIO_COLLECTIVE)
    errors = []
    for name, field in fields.items():
        own = pieces(field)
        for call in range(int(comm.max([len(own)])[0])):
            rows = np.empty((0, field.shape[1]), dtype=field.stored)
            if call < len(own) and not errors:
                found = _or_error(field.read, *own[call])
                rows, errors = (rows, [found]) if isinstance(found, Exception) else (found, errors)
            start = own[call][0] if len(rows) else 0
            failed = _or_error(_put_collectively, file[name], start, rows, collective)
            errors += [failed] if failed else []
    with guarded(comm, doing):
        try:
            file.close()
        finally:
            if errors:
                raise errors[0]
    with guarded(comm, doing), h5py.File(path, "r", locking=False) as file:
        for name, field in fields.items():
            for start, stop in pieces(field):
                if file[name][start:stop].tobytes() != field.read(start, stop).tobytes():
                    raise GfmdError(f"rows {start}:{stop} of {name} did not reach the disk")


def _put_collectively(dataset, start, rows, collective) -> None:
    """Low-level write, because h5py's own cannot take part with no rows."""
    from h5py import h5s

    space = dataset.id.get_space()
    if len(rows):
        memory = h5s.create_simple(rows.shape)
        space.select_hyperslab((start, 0), rows.shape)
    else:
        rows = np.empty((1, 1), dtype=rows.dtype)
        memory = h5s.create_simple((1, 1))
        memory.select_none()
        space.select_none()
    dataset.id.write(memory, space, rows, dxpl=collective)
