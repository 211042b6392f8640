"""K and its inverse applied to whole fields; transfers between a grid and the next coarser one as
matrices, and the sizes that they are tried on."""

import numpy as np

from hpc_gfmd.operators.elastic import reader
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
    return Transfer(n, m, [0, n[0]], 0, dtype), m


def stiffness_times(elastic, u, out):
    """out = K u, local slabs; returns this rank's share of <u, K u>."""
    return _through(elastic, u, elastic.pressure_columns, out)


def compliance_times(elastic, p, out):
    """out = S p with zero mean, local slabs; returns this rank's share of <p, S p>."""
    return _through(elastic, p, elastic.displacement_columns, out)


def _through(elastic, field, columns, out):
    def use(i0, i1, x):
        out[i0:i1] = x[: i1 - i0]

    elastic.pressure_rows(reader(field))
    energy = columns()
    elastic.use_rows(use)
    return energy
