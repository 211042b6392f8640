"""What an attraction adds to the passes, against NumPy."""

import numpy as np
import pytest

from hpc_gfmd.kernels import adhesive_rows
from hpc_gfmd.kernels.bfloat16 import encoded
from hpc_gfmd.kernels.subspace import combine_directions, subspace_products
from hpc_gfmd.laws import law_named
from hpc_gfmd.laws.base import in_precision

N = (7, 10)
every_edge = pytest.mark.parametrize("inside", [N, (5, 8), (0, 0)])
LAW = in_precision(law_named("exponential", 0.3, 0.5), np.dtype(float))


@pytest.fixture
def gaps(random):
    return np.maximum(random.standard_normal(N), 0)


def on_surface(inside):
    here = np.zeros(N, bool)
    here[: inside[0], : inside[1]] = True
    return here


@every_edge
def test_work_of_step(random, gaps, inside):
    d = np.maximum(random.standard_normal(N), -gaps)
    found = adhesive_rows.work_of_step(LAW, gaps, d[2:], 2, 6, inside)
    rows = np.zeros(N, bool)
    rows[2:6] = True
    some = on_surface(inside) & rows
    assert found[0] == pytest.approx(np.sum((LAW.traction(gaps) * d)[some]), abs=1e-12)
    gained = LAW.energy(gaps + d) - LAW.energy(gaps)
    assert found[1] == pytest.approx(np.sum(gained[some]), abs=1e-12)


@every_edge
@pytest.mark.parametrize("s", [1.0, 0.4])
def test_change_of_the_attraction(random, gaps, inside, s):
    """Also of a point that is projected, whose stored step is -infinity."""
    d = encoded(np.maximum(random.standard_normal(N), -gaps / 2), float)
    d[gaps > 1] = -np.inf
    step = np.where(np.isinf(d), -gaps, d).astype(float)
    Kd = random.standard_normal(N)
    y = Kd.copy()
    t, dt = adhesive_rows.add_change(LAW, gaps, d, y, s, 0, N[0], inside)
    some = on_surface(inside)
    change = (LAW.traction(gaps + s * step) - LAW.traction(gaps)) / s
    assert np.allclose(y, Kd + change * some, atol=1e-12)
    assert t == pytest.approx(np.sum(LAW.traction(gaps + s * step)[some]), abs=1e-12)
    assert dt == pytest.approx(np.sum((change * step)[some]), abs=1e-12)


@every_edge
def test_attraction_and_its_energy(random, gaps, inside):
    w = random.standard_normal(N)
    x = w.copy()
    t, phi = adhesive_rows.add_attraction(LAW, gaps, x, 0, N[0], inside)
    some = on_surface(inside)
    assert np.allclose(x, w + LAW.traction(gaps) * some)
    assert t == pytest.approx(np.sum(LAW.traction(gaps)[some]), abs=1e-12)
    assert phi == pytest.approx(np.sum(LAW.energy(gaps)[some]), abs=1e-12)


@every_edge
def test_shift(random, gaps, inside):
    g = gaps + 0.5
    w = random.standard_normal(N)
    some = on_surface(inside)
    r = w + LAW.traction(g) * some
    low = g.copy()
    t = adhesive_rows.shift_gap(LAW, low, r, 0.5, 0, N[0], inside)
    assert np.allclose(low, g - 0.5)
    assert np.allclose(r, w + LAW.traction(low) * some)
    assert t == pytest.approx(np.sum(LAW.traction(low)[some]), abs=1e-12)


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
    found = adhesive_rows.gain_along(LAW, gaps, e, length, 0, N[0], inside)
    gained = LAW.energy(np.maximum(gaps + length * e, 0)) - LAW.energy(gaps)
    assert found == pytest.approx(np.sum(gained[on_surface(inside)]), abs=1e-12)


@every_edge
@pytest.mark.parametrize("length", [0.3, -0.7])
def test_pull_along_a_direction(random, gaps, inside, length):
    e = random.standard_normal(N)
    found = adhesive_rows.pull_along(LAW, gaps, e, length, 0, N[0], inside)
    changed = LAW.traction(np.maximum(gaps + length * e, 0)) - LAW.traction(gaps)
    assert found == pytest.approx(np.sum((changed * e)[on_surface(inside)]), abs=1e-12)


@pytest.mark.parametrize("k", [1, 2, 3])
def test_subspace(random, k):
    V = random.standard_normal((3, *N))
    KV = random.standard_normal((3, *N))
    D = random.random(N)
    sums = np.zeros((2, 3, 3))
    subspace_products(V, KV, D, k, 0, N[0], sums)
    for a in range(k):
        for b in range(a + 1):
            assert sums[0, a, b] == pytest.approx(np.sum(V[a] * KV[b]))
            assert sums[1, a, b] == pytest.approx(np.sum(V[a] * D * V[b]))
    weights = random.standard_normal(3)
    weights[k:] = 0
    news = [np.tensordot(weights[1:], field[1:], 1) for field in (V, KV)]
    bests = [new + weights[0] * field[0] for new, field in zip(news, (V, KV), strict=True)]
    combine_directions(V, KV, k, weights, 0, N[0])
    for field, new, best in zip((V, KV), news, bests, strict=True):
        assert np.allclose(field[0], best)
        assert np.allclose(field[2], new)
