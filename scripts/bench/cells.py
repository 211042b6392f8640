"""The half-space with free edges as most codes discretise it: a pressure that is constant on the
cell around each grid point.

Love's solution for the displacement in the middle of one cell by the pressure on another, in place
of the band-limited Green's function of bodies/free.py. For comparisons on equal terms only, on one
rank, with both axes free.
"""

from dataclasses import dataclass
from functools import lru_cache, partial
from itertools import product

import numpy as np

from hpc_gfmd.bodies.free import Coupled, Free, matrices_of
from hpc_gfmd.bodies.images import images, kernel
from hpc_gfmd.driver.load import Load
from hpc_gfmd.driver.sweep import make_sweep
from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.scene import SolverTable


@lru_cache(1)
def by_cells(case):
    """Return the pressure of the contact by this discretisation, far more accurate than any that is
    measured."""
    sweep = make_sweep(
        partial(case.build, SerialComm()),
        SolverTable(precision="double", residual=1e-9),
        body=Cells((True, True)),
    )
    return np.array(sweep.solve(Load("pressure", case.p_star)).field("pressure"))


@dataclass(frozen=True)
class Cells(Free):
    """See bodies/free.py: nothing but S between two points is different."""

    def make_multipliers(self, grid, fft, q):
        table = _table(grid, fft)
        table[0, 0, 0] = 0  # the rigid translation
        found, length = images(*self._shape(grid)[:-1]), np.sqrt(grid.cell_points)
        modes = length * np.concatenate(table)[: found.modes[1] + 1, : found.modes[0] + 1].T
        S = np.divide(1, modes, out=np.zeros_like(modes), where=modes > 0)
        made = Coupled(grid, fft, q, found, matrices_of(found, S, fft.dtype))
        made.factors = *made.factors[:-1], table
        return made


def _table(grid, fft):
    """Make K of the periodic cell: S less what `Coupled` adds to it."""
    out = np.zeros((fft.K, fft.W, grid.n[0] // 2 + 1), fft.dtype)
    cell = [k * s / grid.a for k, s in zip(grid.n, grid.spacings)]
    half = [s / grid.a / 2 for s in grid.spacings]

    def rows(i0, i1, out):
        points = np.arange(i0, i1), np.arange(grid.n[1])
        x, y = (2 * h * np.minimum(i, n - i) for h, i, n in zip(half, points, grid.n))
        out[: i1 - i0] = love(x, y, *half) - kernel(x, y, *cell)

    def keep(block, m):
        out[m, : len(block)] = 1 / block.real[:, : grid.n[0] // 2 + 1]

    fft.forward_rows(rows)
    fft.columns(keep, backward=False)
    return out


def love(x, y, a, b):
    """Compute S at distances x, y from the middle of a cell of 2a x 2b under pressure 1, all over
    the root of its area."""
    signs = product((1, -1), repeat=2)
    return sum(s * t * _corner(x[:, None] + s * a, y + t * b) for s, t in signs) / np.pi


def _corner(x, y):
    """Integrate 1/r over the rectangle between the origin and (x, y)."""
    return x * np.arcsinh(y / np.abs(x)) + y * np.arcsinh(x / np.abs(y))
