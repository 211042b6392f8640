"""Self-affine random surfaces, made in Fourier space on all ranks at once in the memory of one spectrum."""

import numpy as np

from ..kernels.surface import self_affine
from .statistics import rms_of_columns


def self_affine_heights(spec, grid, dtype):
    """Heights (local slab, dtype) with g_rms = 1 per grid spacing, and their h_rms; spec: scene.SelfAffine."""
    fft = grid.fft(dtype)
    low = spec.L_over_lam_l
    high = low * spec.lam_l_over_lam_s
    rolloff = low * spec.lam_l_over_lam_r
    seed = np.uint64(spec.seed)

    def make(block, m):
        j0, j1 = fft.columns_of(m)
        self_affine(block, j0, j1 - j0, grid.n[1], seed, float(spec.aspect), float(low), float(high), float(rolloff),
                    1.0 + spec.hurst)

    h_rms, g_rms = rms_of_columns(grid, fft, make, backward=True)
    z = grid.empty(dtype)

    def use(i0, i1, x):
        np.multiply(x[: i1 - i0], fft.dtype.type(1.0 / g_rms), out=z[i0:i1])

    fft.backward_rows(use)
    return z, h_rms / g_rms
