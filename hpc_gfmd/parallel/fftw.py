"""FFTW, loaded from mpi4py-fft if that is installed."""

import ctypes
from functools import cache
from importlib.machinery import PathFinder
from importlib.util import find_spec

# of the functions of FFTW for numbers of a type, and of mpi4py-fft's modules
PREFIXES = {"float64": "fftw_", "float32": "fftwf_"}


@cache
def load_fftw() -> dict[str, ctypes.PyDLL] | None:
    """Return the libraries with FFTW's functions, by "float32" and "float64".

    None if a library or its functions are missing. They are mpi4py-fft's compiled modules, loaded
    without importing the package. Importing it would import mpi4py, which starts MPI, or, if it is
    told not to, stays like that for whoever needs MPI later in this process.
    """
    package = find_spec("mpi4py_fft")
    folders = (package and package.submodule_search_locations) or []
    places = [f"{folder}/fftw" for folder in folders]
    libraries = {}
    try:
        for real, prefix in PREFIXES.items():
            module = PathFinder.find_spec(f"{prefix}xfftn", places)
            if module is None:
                return None
            libraries[real] = ctypes.PyDLL(module.origin)
            libraries[real][f"{prefix}plan_many_dft"]
    except (OSError, AttributeError):
        return None
    return libraries


def fft_library() -> str:
    """Return the name of the library that does the transforms: FFTW, or else scipy.fft."""
    return "FFTW (mpi4py-fft)" if load_fftw() else "scipy.fft"
