"""Reference operators for tests: stiffness and compliance of whole fields, and transfers between a
grid and the next coarser one as matrices."""

from functools import partial

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
        J = i * m // n
        f = (i * m % n) / n
        P[i, J] += 1 - f
        P[i, (J + 1) % m] += f
    return P if n != m else np.eye(n)


def interpolated(z, n):
    """The field z, interpolated linearly to n points."""
    P_x, P_y = map(interpolation, n, z.shape)
    return P_x @ z @ P_y.T


def restricted(x, m):
    """The field x, restricted to m points: adjoint of interpolation, keeps constants."""
    P_x, P_y = map(interpolation, x.shape, m)
    return P_x.T @ x @ P_y * (m[0] * m[1] / x.size)


def whole(n, dtype=float):
    """(transfer, m) between n points and the m points of the next coarser grid, on one rank."""
    hierarchy = levels(Grid(n))
    m = hierarchy[1].n if len(hierarchy) > 1 else n
    return Transfer(n, m, [0], [n[0]], 0, dtype), m


def stiffness_times(elastic, u, out):
    """out = K u, local slabs; returns this rank's share of <u, K u>."""
    return _through(elastic, u, elastic.columns, out)


def compliance_times(elastic, p, out):
    """out = S p with zero mean, local slabs; returns this rank's share of <p, S p>."""
    return _through(elastic, p, partial(elastic.columns, inverse=True), out)


def assert_same_on_slabs(comm, n, dtype=np.float64, tolerance=1e-12, body=HALF_SPACE, threads=1):
    """Compare K u, S u and their energies on the slabs of all ranks with those on one rank."""
    whole_grid = Grid(n, (1.0, 1.7))
    slab_grid = Grid(n, (1.0, 1.7), comm, threads=threads)
    rows = slice(*slab_grid.rows)
    u = np.random.default_rng(1).standard_normal(n).astype(dtype)
    for apply in (stiffness_times, compliance_times):
        wanted = whole_grid.empty(dtype)
        out = slab_grid.empty(dtype)
        energy = apply(Elastic(whole_grid, body, dtype), u, wanted)
        elastic = Elastic(slab_grid, body, dtype)
        energy_on_slabs = comm.sum([apply(elastic, u[rows], out)])[0]
        assert energy_on_slabs == pytest.approx(energy, rel=10 * tolerance, abs=1e-25)
        largest_error = tolerance * max(np.abs(wanted).max(), 1e-20)
        assert np.abs(out - wanted[rows]).max(initial=0) <= largest_error
        assert elastic.pairs == 1


def matrix(body, grid):
    """The matrix of K, by applying the operator to unit vectors."""
    elastic = Elastic(grid, body, np.float64)
    out = np.empty((grid.N, grid.N))
    for k in range(grid.N):
        u = np.zeros(grid.N)
        x = grid.empty(np.float64)
        u[k] = 1
        stiffness_times(elastic, u.reshape(grid.n), x)
        out[:, k] = x.ravel()
    return out


def _through(elastic, field, columns, out):
    """Transform a field row by row, call `columns`, and write the result to `out`; its energy."""

    def use(i0, i1, x):
        out[i0:i1] = x[: i1 - i0]

    elastic.pressure_rows(reader(field))
    energy = columns()
    elastic.use_rows(use)
    return energy
