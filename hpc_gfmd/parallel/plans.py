"""One-dimensional transforms of many rows or columns at once: FFTW through mpi4py-fft, or scipy.fft
where that is missing.

Rows are called as plan(input, output) on arrays of the planned shape, columns as plan(array), in
place, with one of the numbers of columns that were planned. Plans work without normalisation in
both directions.
"""

from collections.abc import Callable, Sequence

import numpy as np

from .fftw import load_fftw


class Plans:
    """The four transforms of a slab: rows forward and back (real <-> complex), columns forward and
    back (complex).

    real: (R, n_y), half: (R, n_y//2 + 1), blocks: (some columns, n_x) each: scratch arrays of the
    shapes to plan for. Their contents are lost.
    """

    def __init__(self, real: np.ndarray, half: np.ndarray, blocks: Sequence[np.ndarray]):
        libraries = load_fftw()
        if libraries is None:
            self._scipy(real.shape[1])
            return
        fftw = libraries[real.dtype.name]

        def plan(x: np.ndarray, out: np.ndarray, kind: int) -> Callable:
            return fftw.FFT(x, out, (1,), kind, 1, fftw.FFTW_MEASURE)

        self.rows_forward, self.rows_backward = (
            plan(real, half, fftw.R2C),
            plan(half, real, fftw.C2R),
        )
        forward = {len(block): plan(block, block, fftw.C2C_FORWARD) for block in blocks}
        backward = {len(block): plan(block, block, fftw.C2C_BACKWARD) for block in blocks}
        self.columns_forward = lambda x: forward[len(x)](x, x)
        self.columns_backward = lambda x: backward[len(x)](x, x)

    def _scipy(self, n_y: int) -> None:
        from scipy import fft

        put, back = np.copyto, {"axis": 1, "norm": "forward"}
        self.rows_forward = lambda x, out: put(out, fft.rfft(x, axis=1))
        self.rows_backward = lambda x, out: put(out, fft.irfft(x, n=n_y, **back))
        self.columns_forward = lambda x: put(x, fft.fft(x, axis=1))
        self.columns_backward = lambda x: put(x, fft.ifft(x, **back))
