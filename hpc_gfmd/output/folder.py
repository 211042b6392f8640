"""The folder OUT.h5.partial, where a run keeps what is finished; its lock ends with the process."""

import os
import re
import socket
from contextlib import suppress
from pathlib import Path

from ..parallel.committed import committed_file
from ..util.errors import SceneError

GROWING = "result.h5"  # what is finished so far; it becomes the result file at the end
LOCK = "lock"
# steps and head: of earlier versions
_OURS = re.compile(r"(result|checkpoint|head|step-\d+|memory-\d+)\.h5(\.committed)?(\.tmp)?")


def followed(path: str | os.PathLike) -> Path:
    """Return the path, or its target if it is a symbolic link: a result replaces the target."""
    return Path(os.path.realpath(path)) if os.path.islink(path) else Path(path)


def partial_folder(path: str | os.PathLike) -> Path:
    """Return the folder, which need not exist, of the partial results of a run."""
    return Path(f"{followed(path)}.partial")


def has_begun(folder: Path) -> bool:
    """Whether a folder holds an unfinished run, which can be read and resumed."""
    growing = folder / GROWING
    return growing.exists() and committed_file(growing).exists()


def of_earlier_version(folder: Path) -> int:
    """Return the number of finished loads that an earlier version has left in a folder."""
    return len([*folder.glob("step-*.h5")]) if (folder / "head.h5").exists() else 0


def acquire(folder: Path) -> int:
    """Lock a folder, made if missing; return the descriptor that holds the lock. Without locks in
    the file system the run goes on; SceneError names another holder.
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
    """Release the lock; remove the folder unless `keep` is set and a run has begun in it."""
    if not keep or not (has_begun(folder) or of_earlier_version(folder)):
        clear(folder)
    os.close(lock)


def is_held(folder: Path) -> bool:
    """Whether a running process holds the lock of a folder; False if there are no locks."""
    with suppress(OSError), open(folder / LOCK, "rb") as file:
        return _taken(file.fileno(), alone=False)
    return False


def clear(folder: Path, keep_lock: bool = False) -> None:
    """Remove a run's files, the committed state first: what is left if cut short is stale."""
    for file in sorted(folder.glob("*"), key=lambda file: file.suffix != ".committed"):
        if _OURS.fullmatch(file.name):
            file.unlink(missing_ok=True)
    if not keep_lock:
        (folder / LOCK).unlink(missing_ok=True)
        with suppress(OSError):  # there may be other files
            folder.rmdir()


def _taken(descriptor: int, alone: bool) -> bool:
    """Whether another process prevents a lock; if not, this descriptor holds it until closed."""
    try:
        import fcntl

        fcntl.flock(descriptor, (fcntl.LOCK_EX if alone else fcntl.LOCK_SH) | fcntl.LOCK_NB)
    except (ImportError, OSError) as error:
        return isinstance(error, BlockingIOError)
    return False
