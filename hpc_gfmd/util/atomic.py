"""Files that are complete or do not exist."""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from uuid import uuid4


@contextmanager
def atomic_write(path: Path) -> Iterator[Path]:
    """Write to a temporary file that replaces `path` in one move when the block ends.

    After a failure nothing is left. Where the file system supports files without a name, nothing is
    left of a killed process either.

    Parameters
    ----------
    path : Path
        The file to be written.

    Yields
    ------
    Path
        Where to write.
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
