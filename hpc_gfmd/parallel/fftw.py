"""FFTW, which comes with mpi4py-fft, where it is installed."""

import ctypes
import sys
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any

# of the functions of FFTW for numbers of a type, and of the modules
PREFIXES = {"float64": "fftw_", "float32": "fftwf_"}


@cache
def load_fftw() -> dict[str, Any] | None:
    """Return mpi4py-fft's modules of FFTW by the names of their real numbers; None where they are
    missing.

    Its packages import mpi4py, which starts MPI, or, where told not to, is left as it is for
    whoever needs MPI later in this process: the compiled modules are taken without them.
    """
    if "mpi4py_fft" in sys.modules:
        return _compiled()
    found = find_spec("mpi4py_fft")
    if found is None or not found.submodule_search_locations:
        return None
    folder = Path(found.submodule_search_locations[0])
    try:
        for name, place in ("mpi4py_fft", folder), ("mpi4py_fft.fftw", folder / "fftw"):
            sys.modules[name] = ModuleType(name)
            sys.modules[name].__path__ = [str(place)]
        return _compiled()
    finally:
        for name in [name for name in sys.modules if name.partition(".")[0] == "mpi4py_fft"]:
            del sys.modules[name]  # whoever imports them finds the packages as they are


def _compiled() -> dict[str, Any] | None:
    """Return the modules; None where they, or the functions of FFTW in them, cannot be had."""
    try:
        found = {
            real: import_module(f"mpi4py_fft.fftw.{prefix}xfftn")
            for real, prefix in PREFIXES.items()
        }
        for real, prefix in PREFIXES.items():
            ctypes.PyDLL(found[real].__file__)[f"{prefix}plan_many_dft"]
    except (ImportError, OSError, AttributeError):
        return None
    return found


def fft_library() -> str:
    """Name the library that does the transforms."""
    return "FFTW (mpi4py-fft)" if load_fftw() else "scipy.fft"
