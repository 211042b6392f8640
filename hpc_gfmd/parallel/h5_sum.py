"""What HDF5 itself leaves without checksums: texts, and fields (its Fletcher-32 would make writing them half as long again)."""

import json
import zlib

import numpy as np

from ..errors import GfmdError

CHECKSUM, RECORD = "checksum", "record"  # attributes of a field, and of a group
_MODULUS = 2**32


def sealed(attributes: dict) -> dict:
    """The attributes of a group as they are written: without those that are None, and all of them once more in one line of JSON.

    HDF5 keeps texts of any length where it has no checksums, and a flipped bit there may crash it. The JSON has a fixed length, so
    that HDF5's checksums cover it, and we read texts from nowhere else.
    """
    found = {name: _plain(value) for name, value in attributes.items() if value is not None}
    return found | {RECORD: np.bytes_(json.dumps(found))}


def unsealed(group) -> dict:
    """The attributes of a group as Python numbers, texts and lists; raises ValueError if other numbers stand beside the record."""
    found = json.loads(group.attrs[RECORD])
    changed = (set(found) | {RECORD}) ^ set(group.attrs)
    for name, value in found.items():
        text = isinstance(value, str) or (isinstance(value, list) and any(isinstance(one, str) for one in value))
        if name in group.attrs and not text and not _says(group.attrs, name, value):
            changed.add(name)
    if changed:
        raise ValueError(f"{', '.join(sorted(changed))} of {group.name} is not what was written")
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
    """One pass over a field from its first row to its last; raises GfmdError there if an h5.Stored one is damaged."""

    def __init__(self, field):
        self.field, self.shape, self.stored, self._found = field, field.shape, field.stored, 0

    def read(self, start, stop):
        """Rows start <= i < stop; each once."""
        rows = self.field.read(start, stop)
        self._found += rows_sum(rows, start)
        known = self.field.checksum
        if known is not None and stop == self.shape[0] and self._found % _MODULUS != known:
            raise GfmdError(f"{self.field.path}: the numbers of {self.field.dataset} are damaged")
        return rows


def _says(attributes, name, number) -> bool:
    return attributes.get_id(name).dtype.kind != "O" and json.dumps(_plain(attributes[name])) == json.dumps(number)


def _plain(value):
    if isinstance(value, dict):
        return json.dumps(value)
    if isinstance(value, list | tuple | np.ndarray | np.generic):
        value = np.asarray(value).tolist()
    return value.decode("utf-8") if isinstance(value, bytes) else value
