"""Versions of everything that a result may depend on, and the processor."""

import platform
from functools import cache
from importlib import metadata
from pathlib import Path

PACKAGES = ("numpy", "numba", "scipy", "h5py", "mpi4py", "mpi4py-fft")


@cache
def versions() -> dict[str, str | None]:
    """Return {name: version}, of what is installed, without importing it."""
    found = {"hpc_gfmd": _version("hpc-gfmd"), "python": platform.python_version()}
    return found | {name: v for name in PACKAGES if (v := _version(name))}


@cache
def processor() -> str:
    """Return the model of this machine's processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        return next(
            line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")
        )
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()


def _version(name: str) -> str | None:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None
