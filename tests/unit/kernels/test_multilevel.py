"""Transfers between levels, the sweep of the preconditioner and its products, against NumPy."""

import numpy as np
import pytest
from transfers import SIZES, interpolated, restricted

from hpc_gfmd.bodies.halfspace import HalfSpace
from hpc_gfmd.operators.coarsest import DAMPING
from hpc_gfmd.operators.multilevel import Multilevel
from hpc_gfmd.parallel.coarsening import levels
from hpc_gfmd.parallel.grid import Grid


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
