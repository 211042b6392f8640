"""Small files kept from run to run on this machine: compiled kernels, FFTW's plans, the measured
speed. The program works without them: what is missing or damaged is made again."""

import hashlib
import os
from contextlib import suppress
from pathlib import Path

from .atomic import atomic_write

DIGEST_BYTES = hashlib.sha256().digest_size


def cache_folder() -> Path | None:
    """Return the user's cache folder of this program, which may not exist yet.

    It is $HPC_GFMD_CACHE, $XDG_CACHE_HOME/hpc-gfmd or ~/.cache/hpc-gfmd, the first that is defined;
    None for a user without a home folder.
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
    """Write bytes to a file together with a checksum, for `kept` to read.

    The file is replaced in one step: other processes read the old or the new content. Errors of the
    file system are ignored; the file then stays as it was.

    Parameters
    ----------
    path : Path
        The file. Missing folders are created.
    content : bytes
        What `kept` returns.
    purpose : str, optional
        What the content is for; part of the checksum, so that `kept` returns the content only for
        the same purpose. Default: the file's name.
    """
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        with atomic_write(path) as tmp:
            tmp.write_bytes(_digest(content, path, purpose) + content)


def kept(path: Path, purpose: str | None = None) -> bytes | None:
    """Read the content of a file that `keep` wrote.

    Parameters
    ----------
    path : Path
        The file.
    purpose : str, optional
        The purpose that it was written for; default: the file's name.

    Returns
    -------
    bytes or None
        The content; None if the file cannot be read, is damaged, or was written for another
        purpose.
    """
    try:
        data = path.read_bytes()
    except OSError:
        return None
    digest = data[:DIGEST_BYTES]
    content = data[DIGEST_BYTES:]
    return content if digest == _digest(content, path, purpose) else None


def _digest(content: bytes, path: Path, purpose: str | None) -> bytes:
    """Return the SHA-256 checksum of a content and its purpose (default: the name of `path`)."""
    text = path.name if purpose is None else purpose
    return hashlib.sha256(text.encode("utf-8", "surrogateescape") + b"\0" + content).digest()
