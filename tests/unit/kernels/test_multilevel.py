"""Transfers between levels, the sweep of the preconditioner and its products, against NumPy."""

import numpy as np
import pytest
from transfers import SIZES, interpolated, restricted, whole

from hpc_gfmd.bodies.halfspace import HalfSpace
from hpc_gfmd.kernels import multilevel
from hpc_gfmd.operators.coarsest import DAMPING
from hpc_gfmd.operators.multilevel import Multilevel
from hpc_gfmd.parallel.coarsening import axis_tables, halved, levels
from hpc_gfmd.parallel.grid import Grid


def test_there_are_at_most_two_rows_beside_a_coarse_one():
    for n in range(2, 200):
        (m, _), _ = halved((n, n), (1.0, 1.0))
        J_x, _ = axis_tables(n, m, np.float64)
        assert np.bincount(J_x, minlength=m).min() >= 1
        assert np.bincount(J_x).max() <= 2


@pytest.mark.parametrize("n", SIZES)
def test_transfers_are_adjoint(random, n):
    """<R x, y> N/N_1 = <x, P y>, with R and P as in the reference matrices."""
    transfer, m = whole(n)
    x = random.standard_normal(n)
    y = random.standard_normal(m)
    fine = np.zeros((1, n[0] + 2, n[1]))
    coarse = np.zeros((1, m[0] + 2, m[1]))
    fine[0, 1:-1] = x
    for rows in transfer.passes(3):
        multilevel.restrict_level(fine, coarse, transfer.tables, *rows, tuple(np.empty((2, n[1]))))
    R = coarse[0, 1:-1].copy()
    R[0] += coarse[0, -1]
    R[-1] += coarse[0, 0]
    assert np.allclose(R, restricted(x, m), atol=1e-13)
    Py = np.zeros((1, n[0] + 2, n[1]))
    restricted_fields = np.zeros((2, n[0] + 2, n[1]))
    multilevel.smooth_level(
        restricted_fields,
        y[np.arange(-1, m[0] + 1) % m[0]].copy(),
        Py[0],
        1.0,
        4.0,
        transfer.tables,
        tuple(map(np.ones, n)),
        *(0, n[0]),
        tuple(np.empty((2, max(n[1], m[1])))),
    )
    assert np.allclose(Py[0, 1:-1], interpolated(y, n), atol=1e-13)
    assert np.vdot(R, y) * x.size / y.size == pytest.approx(np.vdot(x, Py[0, 1:-1]), abs=1e-12)


def by_matrices(grid, r, theta, level=0):
    """M' r from a level on: z_l = r_l/(weight_l + c theta_l) + P z_(l+1)."""
    hierarchy = levels(grid)
    z = r / (HalfSpace().weights(grid)[level] + DAMPING * theta)
    if level + 1 < len(hierarchy):
        m = hierarchy[level + 1].n
        coarser = by_matrices(grid, restricted(r, m), restricted(theta, m), level + 1)
        z = z + interpolated(coarser, hierarchy[level].n)
    return z


def swept(grid, p, closed):
    """(M' p on level 1, <p, M' p>) by the sweep of the solver."""
    sweep = Multilevel(grid, HalfSpace(), np.float64, max(grid.n[0], 1))
    g = np.where(closed, 0.0, 1.0)
    sweep.restrict(g, np.where(closed, 1.0, p))
    sums = sweep.sweep()
    return sweep.z[1 : levels(grid)[1].n[0] + 1].copy(), sums[0]


@pytest.mark.parametrize("n", [n for n in SIZES if n != (1, 1)])
def test_sweep(random, n):
    grid = Grid(n)
    closed = random.random(n) < 0.3
    p = np.where(closed, 0, random.standard_normal(n))
    m = levels(grid)[1].n
    wanted = by_matrices(grid, restricted(p, m), restricted(closed, m), 1)
    swept_pressure, energy = swept(grid, p, closed)
    assert np.allclose(swept_pressure, wanted, atol=1e-12)
    assert energy == pytest.approx(np.vdot(p, interpolated(wanted, n)), abs=1e-11)


@pytest.mark.parametrize("coarsest_points", [None, 0])
@pytest.mark.parametrize(
    ("n", "nominal"),
    [((16, 16), (8, 8)), ((30, 12), (15, 12)), ((14, 20), (7, 10)), ((16, 8), (16, 8))],
)
def test_norm_of_the_test_pressure(random, n, nominal, coarsest_points):
    """|w|^2, |v|^2 and <v, w> by sums over levels.

    v = t - share s and w = r - missing t, with the indicators t of contact and s of the surface.
    """
    grid = Grid(n, nominal=nominal)
    sweep = Multilevel(grid, HalfSpace(), np.float64, n[0], coarsest_points)
    s = np.zeros(n)
    s[: nominal[0], : nominal[1]] = 1
    t = s * (random.random(n) < 0.4)
    r = np.where(t > 0, 0, random.standard_normal(n))
    g = np.where(t > 0, 0.0, 1.0)
    p = np.where(t > 0, 1.0, r)
    sweep.restrict(g, p)
    _, _, _, *products = sweep.sweep()
    sums = sweep.test_products(r.sum(), np.vdot(r, r), t.sum(), *products)

    share = t.sum() / s.sum()
    missing = r.sum() / t.sum()
    v = t - share * s
    w = r - missing * t
    wanted = np.zeros(3)
    for k, (level, softness) in enumerate(zip(levels(grid), HalfSpace().softness(grid))):
        if k:
            v, w = (restricted(x, level.n) for x in (v, w))
        products = np.vdot(w, w), np.vdot(v, v), np.vdot(v, w)
        wanted += softness * grid.cell_points / v.size * np.array(products)
    # points beyond the surface contribute on the finest level
    wanted[2] -= share * r[s == 0].sum()
    assert sums == pytest.approx(wanted, rel=1e-9, abs=1e-9)
