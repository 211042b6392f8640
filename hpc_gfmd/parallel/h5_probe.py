"""Whether the HDF5 library gets through a file, tried in a process of its own: damaged ones may crash it, or keep it busy for ever.

`python -m hpc_gfmd.parallel.h5_probe MODULE FUNCTION ARGUMENTS...` is that process.
"""

import importlib
import os
import resource
import subprocess
import sys
from pathlib import Path

PATIENCE, BYTES_PER_SECOND = 15.0, 1e7  # seconds for a file of no size, and how fast even a slow disk delivers the rest
MOST_MEMORY = 8 * 2**30  # bytes of addresses; a few bytes in a file can stand for any number
# the C library then checks every piece of memory that is freed: damage that does not crash this time is found, too
HARDENED = {"LD_PRELOAD": "libc_malloc_debug.so.0", "GLIBC_TUNABLES": "glibc.malloc.check=3", "MALLOC_CHECK_": "3"}
_LAUNCHER = ("OMPI_", "PMIX_", "PMI_", "PRTE_", "SLURM_")
_COMMAND = (sys.executable, "-m", "hpc_gfmd.parallel.h5_probe")


def survives(function, path, *more) -> bool:
    """Whether a process that calls function(path, *more) comes back. What the function raises does not matter: whoever reads the
    file meets it again. It should do exactly what the reader will do.

    function: of a module, by name; more: texts.
    """
    root = os.fspath(Path(__file__).parents[2])
    # the child is not one of the ranks, even where this process is
    env = {key: value for key, value in os.environ.items() if not key.startswith(_LAUNCHER)}
    env |= {"PYTHONPATH": os.pathsep.join(filter(None, [root, env.get("PYTHONPATH")])), "OPENBLAS_NUM_THREADS": "1"} | HARDENED
    command = [*_COMMAND, function.__module__, function.__name__, os.fspath(path), *more]
    patience = PATIENCE + os.path.getsize(path) / BYTES_PER_SECOND
    try:
        found = subprocess.run(command, capture_output=True, stdin=subprocess.DEVNULL, env=env, timeout=patience)
    except subprocess.TimeoutExpired:
        return False
    return found.returncode == 0


def attempt(function, *arguments) -> None:
    """Call the function; only lack of memory counts as a failure."""
    try:
        function(*arguments)
    except MemoryError:
        raise
    except Exception:
        pass


def main(module, name, *arguments) -> None:
    """The process that may not come back."""
    resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY, MOST_MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    try:
        import mpi4py

        mpi4py.rc.initialize = False
    except ImportError:
        pass
    attempt(getattr(importlib.import_module(module), name), *arguments)


if __name__ == "__main__":
    main(*sys.argv[1:])
