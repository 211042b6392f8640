"""One run per result file: a lock that the kernel gives back when its holder dies, however it dies."""

import errno
import fcntl
import os
import socket
from pathlib import Path

from ..errors import SceneError

NAME = "lock"
_TAKEN = (errno.EAGAIN, errno.EACCES)


def acquire(folder: Path) -> int:
    """Lock `folder` and return the open descriptor that holds the lock.

    Raises SceneError naming the holder if another process has it. A file system without locks is accepted.
    """
    path = folder / NAME
    while True:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            if error.errno in _TAKEN:
                holder = os.read(descriptor, 200).decode(errors="replace").strip() or "another process"
                os.close(descriptor)
                file = folder.with_suffix("")
                raise SceneError(f"{file}: another run is writing this file ({holder})") from None
        # the holder before us may have removed the folder between our open and our lock
        if path.exists() and os.path.samestat(os.fstat(descriptor), os.stat(path)):
            break
        os.close(descriptor)
        folder.mkdir(exist_ok=True)
    os.ftruncate(descriptor, 0)
    os.write(descriptor, f"process {os.getpid()} on {socket.gethostname()}".encode())
    return descriptor


def is_held(folder: Path) -> bool:
    """True while a run holds the lock of `folder`."""
    try:
        descriptor = os.open(folder / NAME, os.O_RDONLY)
    except OSError:
        return False
    try:
        fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
        return False
    except OSError as error:
        return error.errno in _TAKEN
    finally:
        os.close(descriptor)
