"""The folder beside a result file, OUT.h5.partial, where a run keeps what is finished until all of
it is: one run at a time has it, by a lock that the kernel gives back when its holder dies, however
it dies."""

import os
import re
import socket
from contextlib import suppress
from pathlib import Path

from ..util.errors import SceneError

HEAD = "head.h5"
STATE = "checkpoint.h5"
LOCK = "lock"
_OURS = re.compile(r"(head|step-\d+|checkpoint)\.h5(\.tmp)?")


def followed(path: str | os.PathLike) -> Path:
    """Return the file that a path stands for: a link is not replaced by a result, what it
    names is."""
    return Path(os.path.realpath(path)) if os.path.islink(path) else Path(path)


def partial_folder(path: str | os.PathLike) -> Path:
    """Return the folder where a run that writes `path` keeps its finished loads, and the gap of
    one that was stopped."""
    return Path(f"{followed(path)}.partial")


def step_files(folder: Path) -> dict[int, Path]:
    """Find the files of the finished steps, by index."""
    return dict(
        sorted((int(p.stem[5:]), p) for p in folder.glob("step-*.h5") if p.stem[5:].isdigit())
    )


def acquire(folder: Path) -> int:
    """Lock `folder`, made if it is missing, and return the open descriptor that holds the lock.

    Raises SceneError naming the holder if another process has it. A file system without locks is
    accepted.
    """
    folder.mkdir(exist_ok=True)
    descriptor = os.open(folder / LOCK, os.O_RDWR | os.O_CREAT, 0o644)
    if _taken(descriptor, alone=True):
        with os.fdopen(descriptor, errors="replace") as file:
            holder = file.read(200).strip() or "another process"
        raise SceneError(f"{folder.with_suffix('')}: another run is writing this file ({holder})")
    # the holder before us may have removed the folder between our open and our lock
    if not (
        (folder / LOCK).exists() and os.path.samestat(os.fstat(descriptor), os.stat(folder / LOCK))
    ):
        os.close(descriptor)
        return acquire(folder)
    with suppress(OSError):  # a full disk is noticed soon
        os.ftruncate(descriptor, 0)
        os.write(descriptor, f"process {os.getpid()} on {socket.gethostname()}".encode())
    return descriptor


def release(folder: Path, lock: int, keep: bool = True) -> None:
    """Give back the lock that `acquire` returned.

    Parameters
    ----------
    folder : Path
        Beside a result file.
    lock : int
        What `acquire` returned; closed.
    keep : bool
        Whether the folder stays, if a run has begun in it; otherwise it is removed.
    """
    if not keep or not (folder / HEAD).exists():
        clear(folder)
    os.close(lock)


def is_held(folder: Path) -> bool:
    """Return whether a run holds the lock of a folder."""
    with suppress(OSError), open(folder / LOCK, "rb") as file:
        return _taken(file.fileno(), alone=False)
    return False


def clear(folder: Path, keep_lock: bool = False) -> None:
    """Remove the files of a run, the head first: without head.h5 and without a lock a folder is
    stale.

    Parameters
    ----------
    folder : Path
        Beside a result file.
    keep_lock : bool
        Whether the lock and the folder stay.
    """
    for file in sorted(folder.glob("*"), key=lambda file: not file.name.startswith(HEAD)):
        if _OURS.fullmatch(file.name):
            file.unlink(missing_ok=True)
    if not keep_lock:
        (folder / LOCK).unlink(missing_ok=True)
        with suppress(OSError):  # there may be other files
            folder.rmdir()


def _taken(descriptor: int, alone: bool) -> bool:
    """Try to lock a file, alone or shared; return whether another process holds it."""
    try:
        import fcntl

        fcntl.flock(descriptor, (fcntl.LOCK_EX if alone else fcntl.LOCK_SH) | fcntl.LOCK_NB)
    except (ImportError, OSError) as error:
        return isinstance(error, BlockingIOError)
    return False
