"""Files that are there complete or not at all."""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from uuid import uuid4


@contextmanager
def atomic_write(path: Path) -> Iterator[Path]:
    """`with atomic_write(path) as tmp`: what is written to tmp becomes `path` in one move at last.

    Of a failure nothing is left, nor, where the file system has files without a name, of a process
    that is killed.
    """
    named = path.with_name(f".{path.name}.{uuid4().hex[:8]}.tmp")
    tmp, nameless = named, None
    with suppress(OSError, AttributeError):
        nameless = os.open(path.parent, os.O_TMPFILE | os.O_RDWR, 0o666)
        tmp = Path(f"/proc/self/fd/{nameless}")
    try:
        yield tmp
        if nameless is not None:
            os.link(tmp, named, src_dir_fd=nameless)  # with a folder the link is followed
        os.replace(named, path)
    finally:
        named.unlink(missing_ok=True)
        if nameless is not None:
            os.close(nameless)
