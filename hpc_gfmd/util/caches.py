"""Small files kept from run to run (kernels, FFTW's plans, the measured speed); what is missing or
damaged is made again.
"""

import hashlib
import os
from contextlib import suppress
from pathlib import Path

from .atomic import atomic_write

DIGEST_BYTES = hashlib.sha256().digest_size


def cache_folder() -> Path | None:
    """Return the first of $HPC_GFMD_CACHE, $XDG_CACHE_HOME/hpc-gfmd and ~/.cache/hpc-gfmd that is
    defined, which may not exist yet, or None.
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
    """Write bytes to a file in one step with a checksum, for `kept` with the same purpose."""
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        with atomic_write(path) as tmp:
            tmp.write_bytes(_digest(content, path, purpose) + content)


def kept(path: Path, purpose: str | None = None) -> bytes | None:
    """Return what `keep` wrote; None if unreadable, damaged or for another purpose."""
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
