"""The empty form of a result file: attributes, datasets without numbers, and the disk space for all of it.

The HDF5 library does not survive a full disk: a file that it cannot close stays half open and crashes the process
later. So the space is taken first, and the library only ever writes where there is room.
"""

import ctypes
import errno
import io
import json
import os
from pathlib import Path

from ..errors import GfmdError
from . import h5_fill, h5_seal, h5_sum

FORMAT = "hpc-gfmd"
FORMAT_VERSION = 1

# HDF5 1.10 and later read it, and unlike the oldest layout it has checksums on most of the bookkeeping
_VERSIONS = ("v110", "v110")
_BOOKKEEPING = 2**20  # bytes, generous; what is not needed is given back
_PER_ROW = 256  # of a compressed field


def lay_out(path, groups, fields, copies, compressed) -> dict[str, int | None]:
    """Make the file; returns where in it the numbers of each field go, None for compressed ones. One process only.

    Raises GfmdError if the disk space cannot be had; OSError and what else may go wrong comes as it is.
    """
    import h5py

    space = _space(groups, fields, copies, compressed)
    Path(path).write_bytes(_empty_file())
    reserve(path, space)
    with h5py.File(path, "r+", locking=False, libver=_VERSIONS) as file:
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
    if compressed and fields:
        reserve(path, space)  # closing gave the unused part back
    return offsets


def write_sums(path, sums) -> None:
    """Put the checksums of the fields, {dataset: number}, where `lay_out` left room for them."""
    import h5py

    with h5py.File(path, "r+", locking=False, libver=_VERSIONS) as file:
        for name, value in sums.items():
            file[name].attrs.modify(h5_sum.NAME, value)


def reserve(path, size) -> None:
    """Lengthen a file to `size` bytes that are sure to be there; skipped where the file system cannot do it.

    Raises GfmdError if the disk is full or a quota reached.
    """
    libc = ctypes.CDLL(None, use_errno=True)
    fallocate = getattr(libc, "fallocate64", None) or getattr(libc, "fallocate", None)
    if fallocate is None:
        return
    fallocate.argtypes = (ctypes.c_int, ctypes.c_int, ctypes.c_int64, ctypes.c_int64)
    with open(path, "r+b") as file:
        failed = ctypes.get_errno() if fallocate(file.fileno(), 0, 0, size) else 0
    if failed in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
        raise GfmdError(f"{os.strerror(failed)} ({size / 1e6:.4g} MB needed)")


def _space(groups, fields, copies, compressed) -> int:
    """Bytes that are certainly enough: random numbers do not shrink when they are compressed."""
    numbers = sum(field.shape[0] * field.shape[1] * field.stored.itemsize for field in fields.values())
    if compressed:
        numbers += numbers // 500 + _PER_ROW * sum(field.shape[0] for field in fields.values())
    texts = 4 * sum(len(str(attributes)) for attributes in groups.values())
    datasets = 4096 * (len(fields) + len(copies) + len(groups))
    return numbers + texts + datasets + sum(os.path.getsize(s.path) for s in copies.values()) + _BOOKKEEPING


def _empty_file() -> bytes:
    """An HDF5 file with nothing in it, so that the real one is opened rather than cut to length 0 by HDF5."""
    import h5py

    memory = io.BytesIO()
    h5py.File(memory, "w", libver=_VERSIONS, userblock_size=h5_seal.BLOCK).close()
    return memory.getvalue()


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
    group[last].attrs.create(h5_sum.NAME, 0, dtype="int64")
    return None if compressed else dataset.get_offset()
