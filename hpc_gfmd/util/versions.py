"""Versions of the packages that a result may depend on, and the model of the processor."""

import platform
from contextlib import suppress
from functools import cache
from importlib import metadata
from pathlib import Path

PACKAGES = ("hpc_gfmd", "numpy", "numba", "scipy", "h5py", "mpi4py", "mpi4py-fft")


@cache
def versions() -> dict[str, str]:
    """Return the versions of Python and of the installed PACKAGES by name."""
    installed = {"python": platform.python_version()}
    for name in PACKAGES:
        with suppress(metadata.PackageNotFoundError):
            installed[name] = metadata.version(name)
    return installed


@cache
def processor() -> str:
    """Return the model of this machine's processor, or its architecture if that is all there is."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        return next(
            line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")
        )
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()
