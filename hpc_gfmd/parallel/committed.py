"""HDF5 files that grow, and can be brought back to their last complete state.

`commit` keeps the size of a file and all its bytes but the numbers of fields in a second file;
`recover` restores that state, `reading` shows it meanwhile. No field is ever written twice.
"""

import io
import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ..util.atomic import sync


def committed_file(path: Path) -> Path:
    """Return where `commit` keeps what it needs to bring a file back."""
    return path.with_name(path.name + ".committed")


def commit(path: Path) -> None:
    """Make the state of a closed file, whose fields must not change later, the one to recover."""
    size = path.stat().st_size
    places = []
    content = []
    begin = 0
    with open(path, "rb") as file:
        for start, length in [*_numbers_in(path), (size, 0)]:
            if start > begin:
                file.seek(begin)
                content.append(file.read(start - begin))
                places.append((begin, start - begin))
            begin = max(begin, start + length)
    committed = committed_file(path)
    tmp = committed.with_name(committed.name + ".tmp")
    tmp.write_bytes(json.dumps([size, places]).encode() + b"\n" + b"".join(content))
    sync(tmp)
    sync(tmp.replace(committed).parent)


def _numbers_in(path: Path) -> list[tuple[int, int]]:
    """Return (offset, bytes) of all numbers of datasets in a file, in ascending order."""
    places = []

    def note(_: str, item: Any) -> None:
        """Add the places of a dataset."""
        if not hasattr(item, "chunks"):
            return
        if item.chunks:
            for row in range(0, item.shape[0], item.chunks[0]):
                chunk = item.id.get_chunk_info_by_coord((row, 0))
                if chunk.byte_offset is not None:
                    places.append((chunk.byte_offset, chunk.size))
        elif item.id.get_offset() is not None:
            places.append((item.id.get_offset(), item.id.get_storage_size()))

    with _plain(path) as file:
        file.visititems(note)
    return sorted(places)


def _committed(path: Path) -> tuple[int, list[tuple[int, bytes]]]:
    """Return (size, [(offset, bytes)]) of the committed state; ValueError if it is damaged."""
    head, _, content = committed_file(path).read_bytes().partition(b"\n")
    size, places = json.loads(head)
    pieces = []
    for offset, length in places:
        pieces.append((offset, content[:length]))
        content = content[length:]
    return size, pieces


def recover(path: Path) -> None:
    """Bring a file back to its committed state, or remove it if there is none; on one process."""
    if not committed_file(path).exists():
        path.unlink(missing_ok=True)
        return
    size, pieces = _committed(path)
    with open(path, "r+b") as file:
        for offset, content in pieces:
            file.seek(offset)
            file.write(content)
        file.truncate(size)
    sync(path)


class _Growing(io.RawIOBase):
    """A file that may be growing, as it was committed; to read only."""

    def __init__(self, path: Path):
        self.size, self.pieces = _committed(path)
        self.file = open(path, "rb")  # noqa: SIM115
        self.place = 0

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def seek(self, offset: int, whence: int = 0) -> int:
        self.place = offset + (0, self.place, self.size)[whence]
        return self.place

    def tell(self) -> int:
        return self.place

    def readinto(self, buffer: Any) -> int:
        """Read what the file has, with the committed bytes in place of its own."""
        view = memoryview(buffer).cast("B")
        begin = self.place
        count = min(len(view), self.size - begin)
        self.file.seek(begin)
        self.file.readinto(view[:count])
        for offset, content in self.pieces:
            start = max(offset, begin)
            stop = min(offset + len(content), begin + count)
            if start < stop:
                view[start - begin : stop - begin] = content[start - offset : stop - offset]
        self.place += count
        return count

    def close(self) -> None:
        self.file.close()
        super().close()


@contextmanager
def reading(path: Path) -> Iterator[Any]:
    """Open an h5py file to read as it was committed, without a lock, even while it is written."""
    import h5py

    if not committed_file(path).exists():
        with _plain(path) as file:
            yield file
        return
    with _Growing(path) as growing, h5py.File(growing, "r") as file:
        yield file


def _plain(path: Path) -> Any:
    """Open an h5py file for reading, without locking it where HDF5 allows that."""
    import h5py

    try:
        return h5py.File(path, "r", locking=False)
    except OSError as error:
        if "locking flag" not in str(error):
            raise
        return h5py.File(path, "r")
