"""The response to a small change of the load while no point changes sides: the tangent of the load
curve.

With the points F out of contact, p0 + dp changes the displacement by v dp where

    1 + (K v)(r) = 0 on F,    v = 0 in contact,    d(mean gap)/dp0 = mean(v),

a linear problem, symmetric and positive definite: conjugate gradients, preconditioned as the solver
is, without a projection. With b = 1 on F as the right-hand side the wanted number is b K_FF^-1 b,
and each step adds alpha <r, z> to it: the sum rises, and what is still missing is the squared
energy norm of the error (Hestenes and Stiefel 1952; in finite precision Strakos and Tichy 2002).

Where the surface ends within the grid, F has the points beyond it, too, but the mean gap is over
the surface alone: the mean of v there is added up instead, whose error is of first order in that of
v.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice

import numpy as np
from numpy.typing import DTypeLike

from ..bodies.base import Body
from ..parallel.grid import Grid
from .elastic import Elastic
from .multilevel import Multilevel

DELAY = 2  # steps whose sum is taken for what was missing before them
MARGIN = 0.5  # share of the accuracy asked for that this sum may have
FINEST = 16  # times the rounding error of the precision: no number is more accurate than that
MAX_STEPS = 1000


@dataclass(frozen=True)
class Tangent:
    """Response of a contact to a small change of the load."""

    # -d(mean gap)/dp0 in the problem's units; 0 in full contact, inf where nothing touches, nan if
    # the requested accuracy was not reached
    compliance: float
    error: float  # estimated relative error of the compliance
    pairs: float  # FFT pairs it took
    # d(approach)/dp0; nan for a half-space with a periodic axis, which has no approach, in full
    # contact, and where nothing touches
    approach: float = np.nan


def tangent(
    grid: Grid, body: Body, contact: np.ndarray, dtype: DTypeLike, accuracy: float
) -> Tangent:
    """Compute the response of a contact (local slab, bool) to a relative accuracy, in the memory of
    four fields and levels. Collective.
    """
    closed = int(grid.comm.sum([np.count_nonzero(contact)])[0])
    if closed in (0, grid.cell_points):
        return Tangent(0.0 if closed else np.inf, 0.0, 0.0)
    elastic = Elastic(grid, body, dtype)
    rounding = float(np.finfo(dtype).eps)
    order = 2 if grid.padded else 1
    accuracy = max(accuracy**order, FINEST * rounding / MARGIN)
    total = 0.0
    on_surface = 0.0
    gains = [np.inf] * DELAY
    for gain, inner in islice(_steps(elastic, contact), MAX_STEPS):
        gains = [*gains[1:], gain]
        total += gain
        on_surface += inner
        if np.isnan(total) or sum(gains) <= MARGIN * accuracy * total:
            break
    else:
        total = np.nan
    error = max(sum(gains) / total, FINEST * rounding) ** (1 / order)
    uniform = elastic.multipliers.uniform
    cell = grid.cell_points
    approach = float(1 / uniform + total / cell) * grid.N / cell if uniform else np.nan
    if grid.padded:
        total = on_surface + 0 * total  # nan stays
    return Tangent(total / cell, error, elastic.pairs, approach)


def _steps(elastic: Elastic, contact: np.ndarray) -> Iterator[tuple[float, float]]:
    """Yield each step's gains of b K_FF^-1 b and of the sum of v over the surface. Collective."""
    grid = elastic.grid
    dtype = elastic.dtype
    levels = Multilevel(grid, elastic.body, dtype, elastic.fft.R)
    rows, n_y = grid.shape
    inner_rows, points = grid.inside
    # with the halo rows that the transfer expects
    residual_and_contact = np.zeros((2, rows + 2, n_y), dtype)
    residual, closed = residual_and_contact[:, 1:-1]
    closed[...] = contact
    residual[...] = 1 - closed
    z = np.zeros((rows + 2, n_y), dtype)
    d = np.zeros((rows, n_y), dtype)
    rz = np.inf
    beta = 0.0
    alpha = 0.0

    def fill(i0: int, i1: int, x: np.ndarray) -> float:
        d[i0:i1] *= beta
        d[i0:i1] += z[1 + i0 : 1 + i1] * (1 - closed[i0:i1])
        x[: i1 - i0] = d[i0:i1]
        inner = d[i0 : max(min(i1, inner_rows), i0), :points]
        return inner.sum(dtype=np.float64) if grid.padded else 0.0

    def use(i0: int, i1: int, x: np.ndarray) -> None:
        residual[i0:i1] -= alpha * x[: i1 - i0] * (1 - closed[i0:i1])

    while True:
        rz_before = rz
        rz = levels.precondition(residual_and_contact, z)
        beta = rz / rz_before if rz > 0 else 0.0
        inner = sum(elastic.pressure_rows(fill))
        dKd, inner = grid.comm.sum([elastic.columns(), inner]).tolist()
        alpha = rz / dKd if dKd > 0 or np.isnan(dKd) else 0.0  # 0: solved to the last bit
        elastic.use_rows(use)
        yield alpha * rz, alpha * inner
