"""Checksums of fields: one number for all rows together, whatever the number of ranks and the pieces in which they are read."""

import zlib

NAME = "checksum"  # the attribute of a dataset
_MODULUS = 2**32


def rows_sum(rows, start) -> int:
    """Of rows start, start + 1, ...: the sum of each one's CRC-32, begun with its number, so that their order counts."""
    return sum(zlib.crc32(row.data, start + i) for i, row in enumerate(rows)) % _MODULUS


class Summed:
    """A field (h5.Slab or h5.Stored) that adds up the checksums of the rows that are read; the same rows twice count once."""

    def __init__(self, field):
        self.field, self.shape, self.stored, self.span = field, field.shape, field.stored, field.span
        self._sums = {}

    def read(self, start, stop):
        """Rows start <= i < stop."""
        rows = self.field.read(start, stop)
        self._sums[start, stop] = rows_sum(rows, start)
        return rows

    @property
    def sum(self) -> int:
        """Of all that was read."""
        return sum(self._sums.values()) % _MODULUS


def total(comm, sums) -> list[int]:
    """The sums of all ranks. Collective."""
    return [int(x) % _MODULUS for x in comm.sum(sums)] if sums else []
