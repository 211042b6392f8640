"""FFTW, which comes with mpi4py-fft, where it is installed."""

import sys
from typing import Any

from .launcher import launched


def load_fftw() -> Any:
    """mpi4py_fft.fftw, or None. A process that no launcher started must not initialise MPI only to get at FFTW."""
    if "mpi4py.MPI" not in sys.modules and not launched()[0]:
        try:
            import mpi4py
        except ImportError:
            return None
        mpi4py.rc.initialize = False
    try:
        from mpi4py_fft import fftw
    except ImportError:
        return None
    return fftw


def fft_library() -> str:
    """Name of the library that does the transforms."""
    return "FFTW (mpi4py-fft)" if load_fftw() else "scipy.fft"
