"""Rms height and rms slope of a field, from its spectrum or from differences of neighbours."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from ..kernels.spectral import spectrum_sums
from ..parallel import halo
from ..parallel.grid import Grid
from ..parallel.threads import added


@dataclass(frozen=True)
class Roughness:
    """Rms height, slope and curvature (half of the Laplacian) of a periodic surface."""

    h_rms: float
    g_rms: float
    curvature: float

    def in_units(self, height: float, length: float) -> Self:
        """Return a copy in lengths; height, length: what heights and distances are in units of."""
        return type(self)(
            self.h_rms * height, self.g_rms * height / length, self.curvature * height / length**2
        )


def rms(grid: Grid, fill: Any) -> tuple[float, float]:
    """Return rms height and slope (per spacing a) of a periodic field: sums of |h_q|^2 and q^2
    |h_q|^2, half an FFT pair in double. fill(i0, i1, x) writes local rows, on threads. Collective.
    """
    fft = grid.fft(np.float64)
    fft.forward_rows(fill)
    roughness = roughness_of_columns(grid, fft, None)
    return roughness.h_rms, roughness.g_rms


def rms_between_neighbours(grid: Grid, fill: Any, free: tuple[bool, bool]) -> tuple[float, float]:
    """Return rms height and slope (per spacing a) by neighbours, not across free edges. Collective.
    fill(i0, i1, x) writes local rows of a field whose mean is small; it is called once.
    """
    x = np.empty(grid.shape)
    fill(0, len(x), x)
    below = halo.next_row(grid.comm, x[:1], grid.starts)[None]
    if free[0] and grid.rows[1] == grid.n[0]:
        below = x[-1:]  # the last row has no next one
    beside = x[:, -1:] if free[1] else x[:, :1]
    sums = [np.sum(x), np.vdot(x, x)]
    differences = np.empty(x.shape)
    for lines, next_line, difference in ((x, below, differences), (x.T, beside.T, differences.T)):
        np.subtract(lines[1:], lines[:-1], out=difference[:-1])
        np.subtract(next_line, lines[-1:], out=difference[-1:])
        differences *= differences
        sums.append(np.sum(differences))
    total, s0, s_x, s_y = grid.comm.sum(sums)
    variance = max(s0 / grid.N - (total / grid.N) ** 2, 0.0)
    steps = [max(n - ends, 1) for n, ends in zip(grid.n, free)]
    a_x, a_y = (s / grid.a for s in grid.spacings)
    return float(np.sqrt(variance)), float(
        np.sqrt(s_x / (steps[0] * grid.n[1]) / a_x**2 + s_y / (grid.n[0] * steps[1]) / a_y**2)
    )


def roughness_of_columns(grid: Grid, fft: Any, make: Any) -> Roughness:
    """Return the roughness, in the field's unit and a, from columns of a spectrum. Collective.

    make(block, m) writes h_q into a block of zeros, on threads; then fft holds rows for
    backward_rows. Without it fft holds what forward_rows has transformed.
    """
    q_x = grid.q_x.astype(fft.dtype)
    q_y, weight = grid.once(("columns", fft.dtype), lambda: grid.column_tables(fft))

    def apply(block: np.ndarray, m: int) -> Any:
        if make is not None:
            make(block, m)
        return spectrum_sums(block, q_x, q_y[m], weight[m])

    sums = fft.columns(apply, forward=make is None, backward=make is not None)
    moments = grid.comm.sum(added(sums, 3))
    norm = fft.scale if make is None else 1.0
    h_rms, g_rms, laplacian = (float(np.sqrt(moment) * norm) for moment in moments)
    return Roughness(h_rms, g_rms, laplacian / 2)
