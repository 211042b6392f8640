"""Files that are kept from run to run on this machine: compiled kernels, FFTW's plans, the measured
speed. None of them is ever needed: what is missing or damaged is made again."""

import hashlib
import os
from contextlib import suppress
from pathlib import Path

from .atomic import atomic_write

DIGEST_BYTES = hashlib.sha256().digest_size


def cache_folder() -> Path | None:
    """Return the user's cache folder of this program, or None where the user has no home.

    The environment variables HPC_GFMD_CACHE and XDG_CACHE_HOME move it.
    """
    if folder := os.environ.get("HPC_GFMD_CACHE"):
        return Path(folder)
    if folder := os.environ.get("XDG_CACHE_HOME"):
        return Path(folder) / "hpc-gfmd"
    try:
        home = Path.home()
    except RuntimeError:  # HOME is not set, and the user has no name: as in containers
        return None
    return home / ".cache" / "hpc-gfmd" if home.is_absolute() else None


def keep(path: Path, content: bytes, purpose: str | None = None) -> None:
    """Write a file that begins with the checksum of its content and of its purpose.

    Whoever reads it meanwhile sees the old or the new file. Where it cannot be written nothing
    happens.

    Parameters
    ----------
    path : Path
        The file; its folder is made.
    content : bytes
        What `kept` returns.
    purpose : str, optional
        What the content is for; default: the file's name. A file that was kept for another purpose
        is none.
    """
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        with atomic_write(path) as tmp:
            tmp.write_bytes(_digest(content, path, purpose) + content)


def kept(path: Path, purpose: str | None = None) -> bytes | None:
    """Read a file that `keep` wrote.

    Parameters
    ----------
    path : Path
        The file.
    purpose : str, optional
        What it was kept for; default: the file's name.

    Returns
    -------
    bytes or None
        The content; None where there is no such file, where any byte of it has changed, or where it
        was kept for another purpose.
    """
    try:
        data = path.read_bytes()
    except OSError:
        return None
    digest = data[:DIGEST_BYTES]
    content = data[DIGEST_BYTES:]
    return content if digest == _digest(content, path, purpose) else None


def _digest(content: bytes, path: Path, purpose: str | None) -> bytes:
    """Return the checksum of a content that is kept for a purpose."""
    text = path.name if purpose is None else purpose
    return hashlib.sha256(text.encode("utf-8", "surrogateescape") + b"\0" + content).digest()
