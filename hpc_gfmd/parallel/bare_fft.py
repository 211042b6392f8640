"""FFT pairs of whole fields as other programs do them: what the passes of fft.py are measured against.

Each class plans in __init__ and owns its (zero) fields; a call transforms forward and back, without normalisation. Only for
measurements: raises GfmdError where mpi4py-fft is missing.
"""

import numpy as np

from ..errors import GfmdError


def _fftw():
    """mpi4py_fft with MPI initialised, which it needs even on one process."""
    try:
        from mpi4py import MPI

        if not MPI.Is_initialized():
            MPI.Init()
        import mpi4py_fft
    except ImportError as error:
        raise GfmdError(f"mpi4py-fft cannot be imported ({error}): install the extra 'mpi'") from None
    return mpi4py_fft, MPI


class PfftPair:
    """mpi4py-fft's PFFT as planned by default; distributed over comm."""

    name = "PFFT"

    def __init__(self, n, dtype, comm):
        mpi4py_fft, MPI = _fftw()
        self.pfft = mpi4py_fft.PFFT(comm.mpi or MPI.COMM_SELF, n, dtype=np.dtype(dtype))
        for transform in (self.pfft.forward, self.pfft.backward):
            transform.input_array[...] = 0

    def __call__(self):
        self.pfft.forward(normalize=False)
        self.pfft.backward(normalize=False)


class InPlacePair:
    """Rows real to complex, columns in place: two plans of FFTW on the whole field. One rank."""

    name = "in-place axis 0"

    def __init__(self, n, dtype, comm):
        fftw = _fftw()[0].fftw
        flags = (fftw.FFTW_MEASURE,)
        self.x = fftw.aligned(n, dtype=np.dtype(dtype))
        self.q = fftw.aligned((n[0], n[1] // 2 + 1), dtype=np.result_type(dtype, np.complex64))
        self.plans = ((fftw.rfftn(self.x, None, (1,), 1, flags, self.q), self.x, self.q),
                      (fftw.fftn(self.q, None, (0,), 1, flags, self.q), self.q, self.q),
                      (fftw.ifftn(self.q, None, (0,), 1, flags, output_array=self.q), self.q, self.q),
                      (fftw.irfftn(self.q, (n[1],), (1,), 1, flags, output_array=self.x), self.q, self.x))
        self.x[...], self.q[...] = 0, 0

    def __call__(self):
        for plan, source, target in self.plans:
            plan(source, target)


class Fftw2dPair:
    """FFTW's two-dimensional real-to-complex plan and its inverse. One rank."""

    name = "FFTW 2-D"

    def __init__(self, n, dtype, comm):
        fftw = _fftw()[0].fftw
        flags = (fftw.FFTW_MEASURE,)
        self.x = fftw.aligned(n, dtype=np.dtype(dtype))
        self.q = fftw.aligned((n[0], n[1] // 2 + 1), dtype=np.result_type(dtype, np.complex64))
        self.forward = fftw.rfftn(self.x, None, (0, 1), 1, flags, self.q)
        self.backward = fftw.irfftn(self.q, tuple(n), (0, 1), 1, flags, output_array=self.x)
        self.x[...], self.q[...] = 0, 0

    def __call__(self):
        self.forward(self.x, self.q)
        self.backward(self.q, self.x)


def bare_pairs(n, dtype, comm):
    """{name: pair} of all that work on this number of ranks."""
    kinds = (PfftPair, InPlacePair, Fftw2dPair) if comm.size == 1 else (PfftPair,)
    return {kind.name: kind(n, dtype, comm) for kind in kinds}
