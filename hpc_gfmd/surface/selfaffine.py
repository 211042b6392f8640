"""Self-affine random surfaces, made in Fourier space on all ranks in the memory of one spectrum."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import DTypeLike

from ..kernels.selfaffine import self_affine
from ..parallel.grid import Grid
from ..parallel.interrupt import check
from .statistics import rms_of_columns


def self_affine_gap(
    spec: Any, grid: Grid, dtype: DTypeLike, made_in: DTypeLike
) -> tuple[np.ndarray, float, Callable]:
    """Make the gap under zero load of a self-affine surface. Collective.

    The transforms of the grid in precision made_in are used as scratch memory.

    Parameters
    ----------
    spec : scene.SelfAffine
    grid : Grid
    dtype : dtype
        Precision of the gap.
    made_in : dtype
        Precision of the transforms. Single precision has several times the errors of storing the
        gap.

    Returns
    -------
    gap : ndarray
        z_max - z, this rank's slab, scaled so that g_rms = 1 per grid spacing.
    h_rms : float
        Rms height, in the unit of the gap.
    add_spectrum : function
        add_spectrum(fft) returns add(block, m), for `fft.columns`: it adds the transform of minus
        the gap, without a factor 1/N, to the columns of block m. It is computed again from the
        seed, so that heights need not be kept.
    """
    fft = grid.fft(made_in)
    low = spec.L_over_lam_l
    high = low * spec.lam_l_over_lam_s
    spectrum = (
        np.uint64(spec.seed),
        spec.aspect,
        low,
        high,
        low * spec.lam_l_over_lam_r,
        1.0 + spec.hurst,
    )

    def adder(fft: Any, keep: float, factor: float, mean: float = 0.0) -> Callable:
        def add(block: np.ndarray, m: int) -> None:
            j0, j1 = fft.columns_of(m)
            self_affine(
                block,
                fft.dtype.type(keep),
                fft.dtype.type(factor),
                j0,
                j1 - j0,
                grid.n[1],
                spectrum,
            )
            if j0 == 0 < j1:
                block[0, 0] += fft.dtype.type(factor * mean)

        return add

    check(grid.comm)
    h_rms, g_rms = rms_of_columns(grid, fft, adder(fft, 0.0, 1.0))
    check(grid.comm)
    tops = fft.backward_rows(lambda i0, i1, x: x[: i1 - i0].max())
    top = fft.dtype.type(grid.comm.max([max(tops, default=-np.inf)])[0])
    h = grid.empty(dtype)

    def use(i0: int, i1: int, x: np.ndarray) -> None:
        rows = x[: i1 - i0]
        np.subtract(top, rows, out=rows)
        np.multiply(rows, fft.dtype.type(1.0 / g_rms), out=h[i0:i1], casting="same_kind")

    check(grid.comm)
    fft.backward_rows(use)
    check(grid.comm)
    return h, h_rms / g_rms, lambda fft: adder(fft, 1.0, grid.N / g_rms, -float(top))
