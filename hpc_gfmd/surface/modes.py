"""Surfaces known by their Fourier modes, made on all ranks in the memory of one spectrum."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import DTypeLike

from ..parallel.grid import Grid
from ..parallel.interrupt import check
from .statistics import Roughness, roughness_of_columns

# add(block, keep, factor, j0, columns): block = keep block + factor times the modes k_y = j0 + w of
# the columns w < columns
AddModes = Callable[[np.ndarray, Any, Any, int, int], None]


@dataclass(frozen=True)
class Modes:
    """The Fourier modes of the heights of a surface."""

    add: AddModes  # called on several threads at once
    # length of the unit of the modes; None if only their shape is given, with h_rms or g_rms
    unit: float | None = None
    checksum: str | None = None  # of the file that they are from; None if the scene determines them
    # prepared(roughness in lengths) returns lines on the surface, see `Surface.prepared`
    prepared: Callable[[Roughness], tuple[str, ...]] | None = None


def gap_of_modes(
    modes: Modes, grid: Grid, precision: Callable[[Roughness], np.dtype], made_in: DTypeLike
) -> tuple[np.ndarray, Roughness, Callable]:
    """Make z_max - z (slab) of modes scaled to g_rms = 1, in the precision(roughness). Collective.

    Also returns the Roughness in units of the modes and of the grid spacing, and add_spectrum(fft)
    -> add(block, m), which adds the transform of minus the gap (without 1/N), computed again so
    that no heights are kept. made_in: precision of the transforms; single has several times the
    error of storing the gap.
    """
    fft = grid.fft(made_in)

    def adder(fft: Any, keep: float, factor: float, mean: float = 0.0) -> Callable:
        def add(block: np.ndarray, m: int) -> None:
            j0, j1 = fft.columns_of(m)
            modes.add(block, fft.dtype.type(keep), fft.dtype.type(factor), j0, j1 - j0)
            if j0 == 0 < j1:
                block[0, 0] += fft.dtype.type(factor * mean)

        return add

    check(grid.comm)
    roughness = roughness_of_columns(grid, fft, adder(fft, 0.0, 1.0))
    dtype = precision(roughness)
    g_rms = roughness.g_rms
    h = grid.empty(dtype)
    keeps = fft.dtype == dtype  # the heights lie in h until their largest is known

    def keep(i0: int, i1: int, x: np.ndarray) -> Any:
        rows = x[: i1 - i0]
        if keeps:
            h[i0:i1] = rows
        return rows.max()

    check(grid.comm)
    tops = fft.backward_rows(keep)
    top = fft.dtype.type(grid.comm.max([max(tops, default=-np.inf)])[0])

    def use(i0: int, i1: int, rows: np.ndarray) -> None:
        np.subtract(top, rows, out=rows)
        np.multiply(rows, fft.dtype.type(1.0 / g_rms), out=h[i0:i1], casting="same_kind")

    check(grid.comm)
    if keeps:
        grid.by_rows(lambda i0, i1: use(i0, i1, h[i0:i1]))
    else:
        fft.backward_rows(lambda i0, i1, x: use(i0, i1, x[: i1 - i0]))
    check(grid.comm)
    return h, roughness, lambda fft: adder(fft, 1.0, grid.N / g_rms, -float(top))
