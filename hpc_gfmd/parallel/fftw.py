"""FFTW, which comes with mpi4py-fft, where it is installed."""

import sys
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any

MODULES = {"float64": "fftw_xfftn", "float32": "fftwf_xfftn"}


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
    try:
        return {
            real: import_module(f"mpi4py_fft.fftw.{module}") for real, module in MODULES.items()
        }
    except ImportError:
        return None


def fft_library() -> str:
    """Name the library that does the transforms."""
    return "FFTW (mpi4py-fft)" if load_fftw() else "scipy.fft"
