"""Files that are complete or do not exist."""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from uuid import uuid4


@contextmanager
def atomic_write(path: Path) -> Iterator[Path]:
    """Yield a temporary file that replaces `path` in one step if the block, which has to close it,
    succeeds.

    With O_TMPFILE even a killed process leaves nothing; its name may then be /proc/self/fd/N,
    without a suffix and for this process alone.
    """
    named = path.with_name(f".{path.name}.{uuid4().hex[:8]}.tmp")
    written = named
    nameless_descriptor = None
    with suppress(OSError, AttributeError):
        nameless_descriptor = os.open(path.parent, os.O_TMPFILE | os.O_RDWR, 0o666)
        written = Path(f"/proc/self/fd/{nameless_descriptor}")
    try:
        yield written
        if nameless_descriptor is not None:
            # src_dir_fd makes the link in /proc be followed
            os.link(written, named, src_dir_fd=nameless_descriptor)
        os.replace(named, path)
    finally:
        named.unlink(missing_ok=True)
        if nameless_descriptor is not None:
            os.close(nameless_descriptor)


def sync(path: Path, wait: bool = True) -> None:
    """Have the system write a file or folder to the disk, or only begin without `wait`."""
    if os.name == "nt":  # no descriptor of a folder
        return
    descriptor = os.open(path, os.O_RDONLY)
    try:
        if wait:
            os.fsync(descriptor)
        elif hasattr(os, "posix_fadvise"):
            os.posix_fadvise(descriptor, 0, 0, os.POSIX_FADV_DONTNEED)
    finally:
        os.close(descriptor)
