"""K and its inverse applied to whole fields; transfers between a grid and the next coarser one as
matrices, and the sizes that they are tried on."""

import numpy as np
import pytest

from hpc_gfmd.bodies.halfspace import HALF_SPACE
from hpc_gfmd.operators.elastic import Elastic, reader
from hpc_gfmd.parallel.coarsening import Transfer, levels
from hpc_gfmd.parallel.grid import Grid

SIZES = [
    (8, 8),
    (9, 9),
    (8, 6),
    (12, 7),
    (5, 16),
    (1, 16),
    (16, 1),
    (2, 2),
    (3, 5),
    (4, 32),
    (17, 33),
    (1, 1),
]


def interpolation(n, m):
    """The matrix of linear interpolation from m to n points of a periodic axis; coarse point J at J
    n/m."""
    P = np.zeros((n, m))
    for i in range(n):
        J, f = i * m // n, (i * m % n) / n
        P[i, J] += 1 - f
        P[i, (J + 1) % m] += f
    return P if n != m else np.eye(n)


def interpolated(z, n):
    """A field on n points, by linear interpolation."""
    P_x, P_y = map(interpolation, n, z.shape)
    return P_x @ z @ P_y.T


def restricted(x, m):
    """A field on m points: the adjoint of interpolation, which keeps constants."""
    P_x, P_y = map(interpolation, x.shape, m)
    return P_x.T @ x @ P_y * (m[0] * m[1] / x.size)


def whole(n, dtype=float):
    """The transfer of a grid that one rank holds, and the points of the coarser one."""
    hierarchy = levels(Grid(n))
    m = hierarchy[1].n if len(hierarchy) > 1 else n
    return Transfer(n, m, [0], [n[0]], 0, dtype), m


def stiffness_times(elastic, u, out):
    """out = K u, local slabs; returns this rank's share of <u, K u>."""
    return _through(elastic, u, elastic.pressure_columns, out)


def compliance_times(elastic, p, out):
    """out = S p with zero mean, local slabs; returns this rank's share of <p, S p>."""
    return _through(elastic, p, elastic.displacement_columns, out)


def assert_same_on_slabs(comm, n, dtype=np.float64, tolerance=1e-12, body=HALF_SPACE, threads=1):
    """K and S on the slabs of all ranks are what they are on one, and so are their energies."""
    whole, grid = Grid(n, (1.0, 1.7)), Grid(n, (1.0, 1.7), comm, threads=threads)
    mine, u = slice(*grid.rows), np.random.default_rng(1).standard_normal(n).astype(dtype)
    for apply in (stiffness_times, compliance_times):
        wanted, out = whole.empty(dtype), grid.empty(dtype)
        energy = apply(Elastic(whole, body, dtype), u, wanted)
        elastic = Elastic(grid, body, dtype)
        found = comm.sum([apply(elastic, u[mine], out)])[0]
        assert found == pytest.approx(energy, rel=10 * tolerance, abs=1e-25)
        least = tolerance * max(np.abs(wanted).max(), 1e-20)
        assert np.abs(out - wanted[mine]).max(initial=0) <= least
        assert elastic.pairs == 1


def matrix(body, grid):
    """K as the operator applies it, column by column."""
    elastic, out = Elastic(grid, body, np.float64), np.empty((grid.N, grid.N))
    for k in range(grid.N):
        u, x = np.zeros(grid.N), grid.empty(np.float64)
        u[k] = 1
        stiffness_times(elastic, u.reshape(grid.n), x)
        out[:, k] = x.ravel()
    return out


def _through(elastic, field, columns, out):
    def use(i0, i1, x):
        out[i0:i1] = x[: i1 - i0]

    elastic.pressure_rows(reader(field))
    energy = columns()
    elastic.use_rows(use)
    return energy
