"""One-dimensional transforms of many rows or columns at once: FFTW through mpi4py-fft, or scipy.fft where that is missing.

A plan is called as plan(input, output) on arrays of the planned shape; both may be the same array for `columns`.
Plans work without normalisation in both directions.
"""

import fcntl
import os
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from ..aligned import empty_aligned
from .comm import launched

PATIENCE = 300.0  # seconds that a process waits for another one's planning


def _load_fftw():
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


def fft_library():
    """Name of the library that does the transforms."""
    return "FFTW (mpi4py-fft)" if _load_fftw() else "scipy.fft"


class Plans:
    """The four transforms of a slab: rows forward and back (real <-> complex), columns forward and back (complex).

    real: (R, n_y), half: (R, n_y//2 + 1), block: (W, n_x): scratch arrays of the shapes to plan for. Their contents are lost.
    """

    def __init__(self, real, half, block):
        fftw = _load_fftw()
        if fftw is None:
            self._scipy(real.shape[1])
            return
        flags = (fftw.FFTW_MEASURE,)
        n_y = (real.shape[1],)
        self.rows_forward = fftw.rfftn(real, None, (1,), 1, flags, half)
        self.rows_backward = fftw.irfftn(half, n_y, (1,), 1, flags, output_array=real)
        self.columns_forward = fftw.fftn(block, None, (1,), 1, flags, block)
        self.columns_backward = fftw.ifftn(block, None, (1,), 1, flags, output_array=block)

    def _scipy(self, n_y):
        from scipy import fft

        def rows_forward(x, out):
            out[...] = fft.rfft(x, axis=1)

        def rows_backward(x, out):
            out[...] = fft.irfft(x, n=n_y, axis=1, norm="forward")

        def columns_forward(x, out):
            out[...] = fft.fft(x, axis=1)

        def columns_backward(x, out):
            out[...] = fft.ifft(x, axis=1, norm="forward")

        self.rows_forward, self.rows_backward = rows_forward, rows_backward
        self.columns_forward, self.columns_backward = columns_forward, columns_backward


def cache_folder():
    """The user's cache folder of this program; HPC_GFMD_CACHE or XDG_CACHE_HOME move it."""
    root = os.environ.get("HPC_GFMD_CACHE")
    if root:
        return Path(root)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "hpc-gfmd"


class Wisdom:
    """FFTW's memory of measured plans, one file per problem size in the user's cache. A cache that cannot be used is no error.

    From its making to `keep` one process plans at a time: all ranks and all later runs then have the plans that were measured first,
    and round in the same way.
    """

    def __init__(self, name, dtype):
        self.path = cache_folder() / "wisdom" / name
        self.library = self.turn = None
        if _load_fftw() is not None:
            from mpi4py_fft.fftw import fftw_xfftn, fftwf_xfftn

            self.library = fftw_xfftn if np.dtype(dtype) == np.float64 else fftwf_xfftn
            tiny = empty_aligned((8,), np.result_type(dtype, np.complex64))
            # The first plan initialises the threads of FFTW, which forgets wisdom read before it.
            _load_fftw().fftn(tiny, None, (0,), 1, (_load_fftw().FFTW_ESTIMATE,), tiny)
            self.turn = self._wait_for_turn()
        self.known = self.library is not None and self.path.exists() and self._read()

    def _wait_for_turn(self):
        """An open file with a lock on it, or None where there are no locks, or somebody keeps it for too long."""
        end = time.monotonic() + PATIENCE
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            file = open(self.path.with_name(f"{self.path.name}.lock"), "w")  # noqa: SIM115
        except OSError:
            return None
        while time.monotonic() < end:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                return file
            except BlockingIOError:
                time.sleep(0.005)
            except OSError:
                break
        file.close()
        return None

    def _read(self):
        return bool(self.library.import_wisdom(os.fsencode(self.path)))

    def keep(self):
        """Write what was measured since, aside and renamed: several jobs may do this at once."""
        if self.library is not None and not self.known:
            self._write()
        if self.turn is not None:
            self.turn.close()  # it is the next one's
            self.turn = None

    def _write(self):
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            with tempfile.NamedTemporaryFile(dir=self.path.parent, delete=False) as file:
                pass
            if self.library.export_wisdom(os.fsencode(file.name)):
                os.replace(file.name, self.path)
            else:
                os.unlink(file.name)
        except OSError:
            pass
