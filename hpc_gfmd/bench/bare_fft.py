"""FFT pairs as other programs do them, of whole fields, on any number of ranks: what our passes are compared with."""

import numpy as np

from ..errors import GfmdError


def bare_pairs(n, dtype, comm):
    """{name: function} of a pair, forward and back, of all that work on this number of ranks: planned, with (zero) fields of their own,
    without normalisation.

    Raises GfmdError where mpi4py-fft is missing.
    """
    try:
        from mpi4py import MPI

        if not MPI.Is_initialized():  # which mpi4py-fft needs even on one process
            MPI.Init()
        from mpi4py_fft import PFFT, fftw
    except ImportError as error:
        raise GfmdError(f"mpi4py-fft cannot be imported ({error}): install the extra 'mpi'") from None
    pfft = PFFT(comm.mpi or MPI.COMM_SELF, n, dtype=np.dtype(dtype))
    for transform in (pfft.forward, pfft.backward):
        transform.input_array[...] = 0

    def default():
        pfft.forward(normalize=False)
        pfft.backward(normalize=False)

    if comm.size > 1:
        return {"PFFT": default}
    x, q = fftw.aligned(n, dtype=np.dtype(dtype)), fftw.aligned((n[0], n[1] // 2 + 1), dtype=np.result_type(dtype, np.complex64))
    flags = (fftw.FFTW_MEASURE,)
    forward = fftw.rfftn(x, None, (0, 1), 1, flags, q)
    backward = fftw.irfftn(q, tuple(n), (0, 1), 1, flags, output_array=x)
    x[...], q[...] = 0, 0

    def two_dimensional():
        forward(x, q)
        backward(q, x)

    return {"PFFT": default, "FFTW 2-D": two_dimensional}
