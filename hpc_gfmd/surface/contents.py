"""The bytes of a file, unpacked, and their format; the name decides only if the bytes do not."""

import bz2
import gzip
import lzma
import re
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import IO, Any, BinaryIO
from zipfile import ZipFile, is_zipfile

HEAD_BYTES = 4096
TEXT_BYTES = 2**20  # without control characters: a text
UNPACKERS: dict[bytes, Callable[[Path], Any]] = {
    b"\x1f\x8b": gzip.open,
    b"BZh": bz2.open,
    b"\xfd7zXZ": lzma.open,
}
SIGNATURES = {  # first bytes: format
    b"\x93NUMPY": "npy",
    b"CDF": "netcdf",
    b"II*\0": "tiff",
    b"MM\0*": "tiff",
    b"II+\0": "tiff",
    b"MM\0+": "tiff",
    b"\x89PNG": "png",
    b"Zygo XYZ Data File": "zygo xyz",
    b"\xff\xd8\xff": "picture",
    b"GIF8": "picture",
    b"BM": "picture",
}
SUFFIXES = {  # formats that a file claims to have, where its first bytes show none
    ".npy": "npy",
    ".npz": "npz",
    ".h5": "hdf5",
    ".hdf5": "hdf5",
    ".nc": "netcdf",
    ".tif": "tiff",
    ".tiff": "tiff",
    ".png": "png",
    ".txt": "text",
    ".csv": "text",
    ".asc": "text",
    ".dat": "text",
    ".xyz": "text",
}
CONTAINER = {"index.json", "meta.yml"}  # of contact.engineering: either tells what else is in it
_HDF5 = b"\x89HDF\r\n\x1a\n"
_USER_BLOCKS = (0, 512, 1024, 2048)  # bytes before an HDF5 file, as in MATLAB's
_UTF16 = (b"\xff\xfe", b"\xfe\xff")
_CONTROL = re.compile(rb"[\x00-\x08\x0e-\x1f]")
_NUMERIC_LINE = re.compile(rb"[\s\d.,;+\-eE]*\d[\s\d.,;+\-eE]*\s")


@dataclass(frozen=True)
class Contents:
    """The bytes of a file."""

    path: Path  # of the file as the scene gives it
    # bytes of a packed file (gzip, bzip2, xz, or one file of a zip), else None
    unpacked: bytes | None = None
    # Name of the file inside a packed one, with its folder in a zip, otherwise that in `path`; its
    # suffix is the format that the file claims to have.
    name: str = ""

    @property
    def source(self) -> Path | BytesIO:
        """What libraries open: the path, or a new stream of the unpacked bytes."""
        return self.path if self.unpacked is None else BytesIO(self.unpacked)

    def open(self) -> BinaryIO:
        """Open the bytes as a binary stream, which the caller closes."""
        return BytesIO(self.unpacked) if self.unpacked is not None else open(self.path, "rb")

    def read(self) -> bytes:
        """Read all bytes."""
        return self.path.read_bytes() if self.unpacked is None else self.unpacked

    @property
    def size(self) -> int:
        """Number of bytes."""
        return self.path.stat().st_size if self.unpacked is None else len(self.unpacked)

    def head(self) -> bytes:
        """Read the first HEAD_BYTES bytes, fewer if there are no more."""
        with self.open() as stream:
            return stream.read(HEAD_BYTES)

    def is_mostly_text(self) -> bool:
        """Whether at most 1 % of the first HEAD_BYTES bytes are control characters."""
        head = self.head()
        return len(_CONTROL.findall(head)) <= 0.01 * len(head)

    @property
    def claimed(self) -> str:
        """The format that belongs to the suffix of the name, "" if none does."""
        return SUFFIXES.get(Path(self.name or self.path.name).suffix.lower(), "")


def contents_of(path: Path, member: str = "") -> Contents:
    """Return the contents of a file, unpacked in memory; member: the file of a zip, else its only
    one. Raises errors of OSError, EOFError, zlib and lzma.
    """
    contents = Contents(path, name=path.name)
    head = contents.head()
    for signature, unpacked in UNPACKERS.items():
        if head.startswith(signature):
            with unpacked(path) as stream:
                return Contents(path, _all_of(stream), path.stem)
    if head.startswith(b"PK\x03\x04") and is_zipfile(path):
        with ZipFile(path) as archive:
            names = files_in(archive)
            if member in names and not CONTAINER & {*names}:
                names = [member]
            if len(names) == 1 and not names[0].endswith(".npy"):
                with archive.open(names[0]) as stream:
                    return Contents(path, _all_of(stream), names[0])
    return contents


def _all_of(stream: IO[bytes]) -> bytes:
    """Read a stream to its end; `read` would hold the bytes twice."""
    whole = BytesIO()
    shutil.copyfileobj(stream, whole)
    return whole.getvalue()


def files_in(archive: ZipFile) -> list[str]:
    """Return the names of the files in a zip, without folders and what macOS adds."""
    return [
        name
        for name in archive.namelist()
        if not name.endswith("/") and not name.startswith("__MACOSX/") and Path(name).name[0] != "."
    ]


def format_of(contents: Contents) -> str:
    """Return the format by the first bytes: "numbers" for a text, "picture" for any but TIFF and
    PNG, "" if only SurfaceTopography may know it.
    """
    head = contents.head()
    if any(head[start:].startswith(_HDF5) for start in _USER_BLOCKS):
        return "hdf5"
    for signature, kind in SIGNATURES.items():
        if head.startswith(signature) and (kind != "picture" or _CONTROL.search(head)):
            return kind
    if head.startswith((b"PK\x03\x04", b"PK\x05\x06")):  # the latter: without files
        return _format_of_archive(contents)
    if is_utf16(head):
        return "text"
    with contents.open() as stream:  # instruments write numbers in binary after much text
        if not head or _CONTROL.search(stream.read(TEXT_BYTES)):
            return ""
    first_line = head.removeprefix(b"\xef\xbb\xbf").lstrip()
    starts_plainly = first_line.startswith(b"#") or _NUMERIC_LINE.match(first_line)
    return "numbers" if starts_plainly else "text"


def is_utf16(head: bytes) -> bool:
    """Whether bytes begin a text in UTF-16: by its mark, or zeros in every second of 18 bytes."""
    if head.startswith(_UTF16):
        return True
    pairs = len(head) // 2
    zeros = max(head[0::2].count(0), head[1::2].count(0))
    return pairs > 8 and zeros > 0.9 * pairs and b"\0\0" not in head[:64]


def _format_of_archive(contents: Contents) -> str:
    """Return "x3p", "container", "npz" or "zip", by the suffix if the archive is damaged."""
    try:
        with contents.open() as stream, ZipFile(stream) as archive:
            paths = archive.namelist()
    except Exception:  # damaged: the reader of what it claims to be says how
        return contents.claimed or "zip"
    if "main.xml" in [Path(path).name for path in paths]:
        return "x3p"
    if CONTAINER & {*paths}:
        return "container"
    return "npz" if any(path.endswith(".npy") for path in paths) else "zip"
