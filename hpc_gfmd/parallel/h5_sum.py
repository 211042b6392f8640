"""Checksums of what HDF5 itself leaves without: texts, and fields (its Fletcher-32 would make writing them half as long again)."""

import json
import zlib

import numpy as np

from ..errors import GfmdError

CHECKSUM = "checksum"  # the attribute of a group or dataset
_MODULUS = 2**32


def sealed(attributes: dict) -> dict:
    """The attributes of a group as they are written: with a checksum, without those that are None."""
    found = {name: _plain(value) for name, value in attributes.items() if value is not None}
    return found | {CHECKSUM: _attributes_sum(found)}


def unsealed(group) -> dict:
    """The attributes of a group as Python numbers, texts and lists; raises ValueError unless they are what was written."""
    found = {name: _plain(value) for name, value in group.attrs.items()}
    if found.pop(CHECKSUM, None) != _attributes_sum(found):
        raise ValueError(f"the attributes of {group.name} are not what was written")
    return found


def rows_sum(rows, start) -> int:
    """Of rows start, start + 1, ...: the sum of their words, hashed with the number of the row; adds up over ranks and pieces."""
    row_bytes = rows.shape[1] * rows.itemsize
    word = next(f"u{size}" for size in (8, 4, 2, 1) if row_bytes % size == 0)
    sums = np.ascontiguousarray(rows).view(word).sum(axis=1, dtype=np.uint64)
    return sum(zlib.crc32(one, start + i) for i, one in enumerate(sums)) % _MODULUS


def total(comm, found) -> int:
    """The sum of all ranks. Collective."""
    return int(comm.sum([found % _MODULUS])[0]) % _MODULUS


class Checked:
    """One pass over an h5.Stored field from its first row to its last; raises GfmdError there if the numbers are damaged."""

    def __init__(self, field):
        self.field, self.shape, self.stored, self._found = field, field.shape, field.stored, 0

    def read(self, start, stop):
        """Rows start <= i < stop; each once."""
        rows = self.field.read(start, stop)
        self._found += rows_sum(rows, start)
        if stop == self.shape[0] and self._found % _MODULUS != self.field.checksum:
            raise GfmdError(f"{self.field.path}: the numbers of {self.field.dataset} are damaged")
        return rows


def _attributes_sum(attributes) -> int:
    return zlib.crc32(json.dumps(attributes, sort_keys=True).encode())


def _plain(value):
    if isinstance(value, dict):
        return json.dumps(value)
    if isinstance(value, list | tuple | np.ndarray | np.generic):
        value = np.asarray(value).tolist()
    return value.decode("utf-8") if isinstance(value, bytes) else value
