"""What is kept from run to run on this machine: measured plans, compiled kernels, the speed.
Nothing of it is ever needed."""

import os
from contextlib import suppress
from pathlib import Path

from .atomic import atomic_write


def cache_folder() -> Path:
    """Return the user's cache folder of this program; HPC_GFMD_CACHE or XDG_CACHE_HOME move it."""
    root = os.environ.get("HPC_GFMD_CACHE")
    if root:
        return Path(root)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "hpc-gfmd"


def keep(path: Path, content: bytes) -> None:
    """Write a file, as `atomic_write`: whoever reads it meanwhile sees the old or the new one. A
    folder that cannot be written is no error."""
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        with atomic_write(path) as tmp:
            tmp.write_bytes(content)
