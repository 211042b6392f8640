"""h_rms and g_rms from the spectrum."""

import numpy as np

from ..kernels.spectral import spectrum_sums


def rms(grid, fill, dtype=np.float64):
    """(h_rms, g_rms) of the field whose rows fill(i0, i1, x) makes; in its unit, and per grid spacing a. Half an FFT pair.

    h_rms^2 = sum_{q != 0} |h_q|^2,  g_rms^2 = sum_q q^2 |h_q|^2.
    """
    fft = grid.fft(dtype)
    fft.forward_rows(fill)
    return rms_of_columns(grid, fft, None)


def rms_of_columns(grid, fft, make, backward=False):
    """As `rms`, of spectra made by make(block, m) (or of the rows transformed before), with h_q in the normalisation of the grid."""
    q_x = grid.q_x.astype(fft.dtype)
    q_y, weight = grid.column_tables(fft)

    def apply(block, m):
        if make is not None:
            make(block, m)
        return spectrum_sums(block, q_x, q_y[m], weight[m])

    sums = fft.columns(apply, forward=make is None, backward=backward)
    s0, s2 = grid.comm.sum(np.sum(np.reshape(sums, (-1, 2)), axis=0))
    norm = fft.scale if make is None else 1.0
    return float(np.sqrt(s0) * norm), float(np.sqrt(s2) * norm)
