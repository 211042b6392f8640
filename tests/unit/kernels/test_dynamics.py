"""One time step of damped dynamics against NumPy."""

import numpy as np
import pytest

from hpc_gfmd.kernels import dynamics

N = (6, 5)


@pytest.mark.parametrize("inside", [N, (4, 3)])
@pytest.mark.parametrize("rows", [[(0, 6)], [(0, 2), (2, 5), (5, 6)]])
def test_verlet_step(random, inside, rows):
    g = np.maximum(random.standard_normal(N), 0)
    p = random.standard_normal(N)
    d = random.standard_normal(N)
    velocity = 0.8 * d - 0.3 * p
    surface = np.zeros(N, bool)
    surface[: inside[0], : inside[1]] = True
    hit = surface & (g + velocity <= 0)
    change = np.where(hit, -g, velocity)
    wanted_g = np.where(hit, 0, g + velocity)
    wanted_d = np.where(hit, 0, velocity)
    for i0, i1 in rows:
        x = np.empty((i1 - i0, N[1]))
        dynamics.verlet_step(g, p, d, x, i0, i1, 0.3, 0.8, inside)
        assert np.allclose(x, change[i0:i1], rtol=1e-14, atol=1e-15)
    assert np.allclose(g, wanted_g)
    assert np.allclose(d, wanted_d)


@pytest.mark.parametrize("inside", [N, (4, 3)])
def test_update_pressure(random, inside):
    g = np.maximum(random.standard_normal(N), 0)
    p = random.standard_normal(N)
    d = random.standard_normal(N)
    x = random.standard_normal(N)
    new = p + x
    surface = np.zeros(N, bool)
    surface[: inside[0], : inside[1]] = True
    contact = surface & (g <= 0) & (new > 0)
    sums = dynamics.update_pressure(g, p, d, x, 0, N[0], inside)
    assert np.allclose(p, new)
    wanted = (
        np.sum(new[~contact] ** 2),
        np.sum(new**2),
        np.sum(new * d),
        np.sum(d**2),
        np.sum(d * x),
        contact.sum(),
        g[surface].sum(),
    )
    assert sums == pytest.approx(wanted, rel=1e-12, abs=1e-12)
