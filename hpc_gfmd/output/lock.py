"""One run per result file: a lock that the kernel gives back when its holder dies, however it dies."""

import errno
import fcntl
import os
import socket
from contextlib import suppress
from pathlib import Path

from ..errors import SceneError

NAME = "lock"
_TAKEN = (errno.EAGAIN, errno.EACCES)


def acquire(folder: Path) -> int:
    """Lock `folder`, made if it is missing, and return the open descriptor that holds the lock.

    Raises SceneError naming the holder if another process has it. A file system without locks is accepted.
    """
    while True:
        folder.mkdir(exist_ok=True)
        descriptor = os.open(folder / NAME, os.O_RDWR | os.O_CREAT, 0o644)
        if _taken(descriptor, fcntl.LOCK_EX):
            holder = os.read(descriptor, 200).decode(errors="replace").strip() or "another process"
            os.close(descriptor)
            raise SceneError(f"{folder.with_suffix('')}: another run is writing this file ({holder})")
        # the holder before us may have removed the folder between our open and our lock
        if (folder / NAME).exists() and os.path.samestat(os.fstat(descriptor), os.stat(folder / NAME)):
            with suppress(OSError):  # a full disk is noticed soon
                os.ftruncate(descriptor, 0)
                os.write(descriptor, f"process {os.getpid()} on {socket.gethostname()}".encode())
            return descriptor
        os.close(descriptor)


def is_held(folder: Path) -> bool:
    """True while a run holds the lock of `folder`."""
    try:
        descriptor = os.open(folder / NAME, os.O_RDONLY)
    except OSError:
        return False
    taken = _taken(descriptor, fcntl.LOCK_SH)
    os.close(descriptor)
    return taken


def _taken(descriptor, kind) -> bool:
    try:
        fcntl.flock(descriptor, kind | fcntl.LOCK_NB)
    except OSError as error:
        return error.errno in _TAKEN
    return False
