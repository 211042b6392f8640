"""Versions of everything that a result may depend on."""

import platform
from importlib import metadata

PACKAGES = ("numpy", "numba", "scipy", "h5py", "mpi4py", "mpi4py-fft")


def versions():
    """{name: version}, of what is installed, without importing it."""
    found = {"hpc_gfmd": _version("hpc-gfmd"), "python": platform.python_version()}
    return found | {name: v for name in PACKAGES if (v := _version(name))}


def _version(name):
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None
