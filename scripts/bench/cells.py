"""The half-space with free edges as most codes discretise it: the pressure is constant on the cell
around each grid point.

The displacement in the middle of a cell by the pressure on another one is Love's solution, in place
of the band-limited Green's function of bodies/free.py. It serves comparisons on equal terms only,
on one rank and with both axes free.
"""

from dataclasses import dataclass
from functools import lru_cache, partial
from itertools import product

import numpy as np

from hpc_gfmd.bodies.free import Coupled, Free, matrices_of
from hpc_gfmd.bodies.images import images, kernel
from hpc_gfmd.driver.contact_model import ContactModel
from hpc_gfmd.driver.load import Load
from hpc_gfmd.driver.sweep import Sweep
from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.scene import SolverTable


@lru_cache(1)
def by_cells(contact):
    """Return the pressure of a RoughContact in this discretisation, far more accurate than what is
    measured."""
    sweep = Sweep(
        partial(contact.build, SerialComm()),
        SolverTable(precision="double", residual=1e-9),
        ContactModel(body=Cells((True, True))),
    )
    return np.array(sweep.solve(Load("pressure", contact.p_star)).field("pressure"))


@dataclass(frozen=True)
class Cells(Free):
    """The body of bodies/free.py with another compliance S between two points."""

    def make_multipliers(self, grid, fft, q):
        table = _table(grid, fft)
        table[0, 0, 0] = 0  # the rigid translation
        body_images = images(*self._shape(grid)[:-1])
        length = np.sqrt(grid.cell_points)
        last_x, last_y = body_images.modes
        modes = length * np.concatenate(table)[: last_y + 1, : last_x + 1].T
        S = np.divide(1, modes, out=np.zeros_like(modes), where=modes > 0)
        multipliers = Coupled(grid, fft, q, body_images, matrices_of(body_images, S, fft.dtype))
        multipliers.factors = *multipliers.factors[:-1], table
        return multipliers


def _table(grid, fft):
    """Return K of the periodic cell: the inverse of S less what `Coupled` adds to it."""
    out = np.zeros((fft.blocks_per_rank, fft.W, grid.n[0] // 2 + 1), fft.dtype)
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
    """Return the compliance S (m, n) of a cell with half sides a and b under unit pressure (Love's
    solution), over the root of its area, at distances x (m,) and y (n,) from its middle."""
    signs = product((1, -1), repeat=2)
    return sum(s * t * _corner(x[:, None] + s * a, y + t * b) for s, t in signs) / np.pi


def _corner(x, y):
    """Return the integral of 1/r over the rectangle between the origin and (x, y)."""
    return x * np.arcsinh(y / np.abs(x)) + y * np.arcsinh(x / np.abs(y))
