"""A seal on result files, so that damaged ones are noticed before the HDF5 library trips over them.

HDF5 does not protect all of its own bookkeeping: a few wrong bytes may change a number silently, or crash the
process that reads the file. HDF5 leaves the first bytes of a file to its user; there we keep a line of text with
the length of the file and a checksum of everything but the fields, which have their own (h5_sum.py). (HDF5 does check its bookkeeping
between them.)
"""

import os
import zlib

BLOCK = 512  # what HDF5 calls the user block
_MAGIC = b"hpc-gfmd seal"
_SIGNATURE = b"\x89HDF\r\n\x1a\n"


def seal(path) -> None:
    """Put the seal on a file that has a user block of BLOCK bytes and is otherwise complete."""
    size = os.path.getsize(path)
    begin, end = _fields_extent(path, size)
    line = b"%s %d %d %d %d\n" % (_MAGIC, size, begin, end, _checksum(path, begin, end))
    with open(path, "r+b") as file:
        file.write(line.ljust(BLOCK, b"\0"))


def check(path) -> str:
    """"intact", "short" (cut off), "broken", "none" (HDF5 without a seal), or "foreign" (no HDF5 at all)."""
    with open(path, "rb") as file:
        head = file.read(BLOCK + len(_SIGNATURE))
    if head.startswith(_SIGNATURE):
        return "none"
    try:
        size, begin, end, checksum = map(int, head[len(_MAGIC) : BLOCK].rstrip(b"\0").split())
    except ValueError:
        return "broken" if head[BLOCK:] == _SIGNATURE else "foreign"
    if os.path.getsize(path) < size:
        return "short"
    if not head.startswith(_MAGIC) or os.path.getsize(path) > size or not BLOCK <= begin <= end <= size:
        return "broken"
    return "intact" if _checksum(path, begin, end) == checksum else "broken"


def _fields_extent(path, size) -> tuple[int, int]:
    """First and last byte of the numbers of all fields; bookkeeping in between has HDF5's own checksums."""
    import h5py

    spans = []

    def look(_, item):
        if not isinstance(item, h5py.Dataset):
            return
        if item.chunks is None:
            spans.append((item.id.get_offset(), item.id.get_storage_size()))
        else:
            chunks = (item.id.get_chunk_info_by_coord((row, 0)) for row in range(0, item.shape[0], item.chunks[0]))
            spans.extend((chunk.byte_offset, chunk.size) for chunk in chunks if chunk.byte_offset is not None)

    with h5py.File(path, "r", locking=False) as file:
        file.visititems(look)
    if not spans:
        return size, size
    return min(start for start, _ in spans), max(start + length for start, length in spans)


def _checksum(path, begin, end) -> int:
    with open(path, "rb") as file:
        file.seek(BLOCK)
        value = zlib.crc32(file.read(begin - BLOCK))
        file.seek(end)
        return zlib.crc32(file.read(), value)
