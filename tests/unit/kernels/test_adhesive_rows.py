"""Contributions of an attraction to the passes of the solver against NumPy."""

import numpy as np
import pytest

from hpc_gfmd.kernels import adhesive_rows
from hpc_gfmd.kernels.bfloat16 import encoded
from hpc_gfmd.laws import law_named
from hpc_gfmd.laws.base import in_precision

N = (7, 10)
every_edge = pytest.mark.parametrize("inside", [N, (5, 8), (0, 0)])
LAW = in_precision(law_named("exponential", 0.3, 0.5), np.dtype(float))


@pytest.fixture
def gaps(random):
    return np.maximum(random.standard_normal(N), 0)


def on_surface(inside):
    mask = np.zeros(N, bool)
    mask[: inside[0], : inside[1]] = True
    return mask


@every_edge
def test_work_of_step(random, gaps, inside):
    d = np.maximum(random.standard_normal(N), -gaps)
    sums = adhesive_rows.work_of_step(LAW, gaps, d[2:], 2, 6, inside)
    rows = np.zeros(N, bool)
    rows[2:6] = True
    counted = on_surface(inside) & rows
    assert sums[0] == pytest.approx(np.sum((LAW.traction(gaps) * d)[counted]), abs=1e-12)
    gained = LAW.energy(gaps + d) - LAW.energy(gaps)
    assert sums[1] == pytest.approx(np.sum(gained[counted]), abs=1e-12)


@every_edge
@pytest.mark.parametrize("s", [1.0, 0.4])
def test_change_of_the_attraction(random, gaps, inside, s):
    """Projected points, whose stored step is -infinity, are included."""
    d = encoded(np.maximum(random.standard_normal(N), -gaps / 2), float)
    d[gaps > 1] = -np.inf
    step = np.where(np.isinf(d), -gaps, d).astype(float)
    Kd = random.standard_normal(N)
    y = Kd.copy()
    t, dt = adhesive_rows.add_change(LAW, gaps, d, y, s, 0, N[0], inside)
    surface = on_surface(inside)
    change = (LAW.traction(gaps + s * step) - LAW.traction(gaps)) / s
    assert np.allclose(y, Kd + change * surface, atol=1e-12)
    assert t == pytest.approx(np.sum(LAW.traction(gaps + s * step)[surface]), abs=1e-12)
    assert dt == pytest.approx(np.sum((change * step)[surface]), abs=1e-12)


@every_edge
def test_attraction_and_its_energy(random, gaps, inside):
    w = random.standard_normal(N)
    x = w.copy()
    t, phi = adhesive_rows.add_attraction(LAW, gaps, x, 0, N[0], inside)
    surface = on_surface(inside)
    assert np.allclose(x, w + LAW.traction(gaps) * surface)
    assert t == pytest.approx(np.sum(LAW.traction(gaps)[surface]), abs=1e-12)
    assert phi == pytest.approx(np.sum(LAW.energy(gaps)[surface]), abs=1e-12)


@every_edge
def test_shift(random, gaps, inside):
    g = gaps + 0.5
    w = random.standard_normal(N)
    surface = on_surface(inside)
    r = w + LAW.traction(g) * surface
    lowered_gap = g.copy()
    t = adhesive_rows.shift_gap(LAW, lowered_gap, r, 0.5, 0, N[0], inside)
    assert np.allclose(lowered_gap, g - 0.5)
    assert np.allclose(r, w + LAW.traction(lowered_gap) * surface)
    assert t == pytest.approx(np.sum(LAW.traction(lowered_gap)[surface]), abs=1e-12)


@every_edge
def test_softening(gaps, inside):
    closed = (gaps == 0).astype(float)
    D = np.empty(N)
    total, largest = adhesive_rows.softening(LAW, gaps, closed, D, 0, N[0], inside)
    wanted = -LAW.curvature(gaps) * (gaps > 0) * on_surface(inside)
    assert np.allclose(D, wanted)
    assert total == pytest.approx(wanted.sum(), abs=1e-12)
    assert largest == pytest.approx(wanted.max(), abs=1e-12)


@every_edge
@pytest.mark.parametrize("length", [0.3, -0.7])
def test_gain_along_a_direction(random, gaps, inside, length):
    e = random.standard_normal(N)
    gain = adhesive_rows.gain_along(LAW, gaps, e, length, 0, N[0], inside)
    gained = LAW.energy(np.maximum(gaps + length * e, 0)) - LAW.energy(gaps)
    assert gain == pytest.approx(np.sum(gained[on_surface(inside)]), abs=1e-12)


@every_edge
@pytest.mark.parametrize("length", [0.3, -0.7])
def test_pull_along_a_direction(random, gaps, inside, length):
    e = random.standard_normal(N)
    pull = adhesive_rows.pull_along(LAW, gaps, e, length, 0, N[0], inside)
    change = LAW.traction(np.maximum(gaps + length * e, 0)) - LAW.traction(gaps)
    assert pull == pytest.approx(np.sum((change * e)[on_surface(inside)]), abs=1e-12)
