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

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import DTypeLike

from .elastic import Elastic
from .multilevel import Multilevel

if TYPE_CHECKING:
    from ..bodies.base import Body
    from ..parallel.grid import Grid

DELAY = 2  # steps whose sum is taken for what was missing before them
MARGIN = 0.5  # share of the accuracy asked for that this sum may have
FINEST = 16  # times the rounding error of the precision: no number is more accurate than that
MAX_STEPS = 1000


@dataclass(frozen=True)
class Tangent:
    """compliance: -d(mean gap)/dp0 in the problem's units, 0 in full contact, inf where nothing
    touches, nan where it was not found to the accuracy asked for; error: estimated, relative;
    pairs: FFT pairs it took; approach: d(approach)/dp0, nan where there is none."""

    compliance: float
    error: float
    pairs: float
    approach: float = np.nan


def tangent(
    grid: Grid, body: Body, contact: np.ndarray, dtype: DTypeLike, accuracy: float
) -> Tangent:
    """The Tangent of the contact of a body: a local slab that is true where points touch.
    Collective.

    Needs four fields and the levels of the preconditioner besides the transforms.
    """
    closed = int(grid.comm.sum([np.count_nonzero(contact)])[0])
    if closed in (0, grid.cell_points):
        return Tangent(0.0 if closed else np.inf, 0.0, 0.0)
    response = _Response(grid, body, contact, np.dtype(dtype))
    rounding = float(np.finfo(dtype).eps)
    order = 2 if grid.padded else 1
    accuracy = max(accuracy**order, FINEST * rounding / MARGIN)
    total, gains = 0.0, [np.inf] * DELAY
    while not sum(gains) <= MARGIN * accuracy * total:
        if response.steps == MAX_STEPS or np.isnan(total):
            total = np.nan
            break
        gains = [*gains[1:], response.step()]
        total += gains[-1]
    error = max(sum(gains) / total, FINEST * rounding) ** (1 / order)
    uniform, cell = response.elastic.multipliers.uniform, grid.cell_points
    approach = float(1 / uniform + total / cell) * grid.N / cell if uniform else np.nan
    if grid.padded:
        total = response.inner + 0 * total  # nan stays
    return Tangent(total / cell, error, response.elastic.pairs, approach)


class _Response:
    """The state of the iteration. `step` returns by how much b K_FF^-1 b has risen."""

    def __init__(self, grid: Grid, body: Body, contact: np.ndarray, dtype: np.dtype):
        self.grid, self.comm = grid, grid.comm
        self.elastic = Elastic(grid, body, dtype)
        self.levels = Multilevel(grid, body, dtype, self.elastic.fft.R)
        rows, n_y = grid.shape
        self.residual_and_contact = np.zeros(
            (2, rows + 2, n_y), dtype
        )  # with the halo rows that the transfer expects
        self.residual, self.contact = self.residual_and_contact[:, 1:-1]
        self.contact[...] = contact
        self.residual[...] = 1 - self.contact
        self.z = np.zeros((rows + 2, n_y), dtype)
        self.d = np.zeros((rows, n_y), dtype)
        self.rz, self.steps = np.inf, 0
        self.inner = 0.0  # sum of v over the surface, where that is not all

    def _precondition(self) -> float:
        """z = M r; returns <r, z>."""
        self.levels.restrict_from(0, self.residual_and_contact)
        self.levels.sweep()
        rz, *_ = self.levels.smooth(0, self.residual_and_contact, self.z)
        return float(self.comm.sum([rz])[0])

    def step(self) -> float:
        """One step of conjugate gradients."""
        self.steps += 1
        before, self.rz = self.rz, self._precondition()
        beta = self.rz / before if self.rz > 0 else 0.0
        z = self.z[1:-1]

        def fill(i0: int, i1: int, x: np.ndarray) -> float:
            d = self.d[i0:i1]
            d *= beta
            d += z[i0:i1] * (1 - self.contact[i0:i1])
            x[: i1 - i0] = d
            return (
                d[: max(self.grid.inside[0] - i0, 0), : self.grid.inside[1]].sum(dtype=np.float64)
                if self.grid.padded
                else 0.0
            )

        inner = sum(self.elastic.pressure_rows(fill))
        dKd, inner = self.comm.sum([self.elastic.pressure_columns(), inner]).tolist()
        alpha = self.rz / dKd if dKd > 0 or np.isnan(dKd) else 0.0  # 0: solved to the last bit

        def use(i0: int, i1: int, x: np.ndarray) -> None:
            self.residual[i0:i1] -= alpha * x[: i1 - i0] * (1 - self.contact[i0:i1])

        self.elastic.use_rows(use)
        self.inner += alpha * inner
        return alpha * self.rz
