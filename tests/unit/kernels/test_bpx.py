"""The passes of the default solver against what they mean, written down once more in NumPy."""

import numpy as np
import pytest
from transfers import SIZES, interpolation, whole

from hpc_gfmd.bodies.halfspace import HalfSpace
from hpc_gfmd.grid import Grid
from hpc_gfmd.kernels import bpx
from hpc_gfmd.kernels.halfwidth import INFINITE, Widened, narrow, narrowed, widen
from hpc_gfmd.operators.multilevel import Multilevel


def state(random, n, dtype=float):
    g = np.maximum(random.standard_normal(n), 0).astype(dtype)
    p = random.standard_normal(n).astype(dtype)
    d = narrowed(random.standard_normal(n) * (g > 0))
    return g, p, d


@pytest.mark.parametrize("n", SIZES, ids=str)
@pytest.mark.parametrize("coupling", [0.0, 1.1])
def test_projected_step(random, n, coupling):
    g, p, d = state(random, n)
    t, m, P_x, P_y = whole(n)
    z_coarse = random.standard_normal(m)
    padded = z_coarse[np.arange(-1, m[0] + 1) % m[0]].copy()
    a, b, compliance = 0.7, -0.2, 0.6
    z = compliance * (p + coupling * P_x @ z_coarse @ P_y.T)
    closed = (g <= 0) & (p > 0)
    d[g > 1] = INFINITE  # clipped the last time: no step for the next one
    last = np.where(g > 1, 0, Widened(d)[:])
    wanted = np.where(closed, 0, np.maximum(g - a * z - b * last, 0) - g)
    x, work = np.empty(n), np.zeros((2, n[1] + 1))
    found = bpx.projected_step(g, p, d, x, (0, n[0]), padded, t.tables, (a, b, coupling, compliance), n, work)
    assert np.allclose(x, wanted, rtol=1 / 128, atol=1e-13)
    clipped = (wanted == -g) & ~closed
    assert np.array_equal(x[clipped], -g[clipped])  # to the bit
    assert np.array_equal(np.maximum(Widened(d)[:], -g), x)  # what `update_state` takes it for
    assert np.all(g + x >= 0)
    assert found == pytest.approx(np.vdot(p, x), abs=1e-12)


def test_half_the_width(random):
    """As NumPy cuts them off; nothing becomes larger, and infinity stays what it is."""
    numbers = np.concatenate([random.standard_normal(999) * 10.0 ** random.integers(-30, 30, 999), [0, -np.inf, np.inf]])
    bits = narrowed(numbers)
    assert np.array_equal([narrow(number) for number in numbers], bits)
    assert np.array_equal([widen(one) for one in bits], Widened(bits)[:])
    assert np.allclose(Widened(bits)[:], numbers, rtol=1 / 128, atol=0)
    assert np.all(np.abs(Widened(bits)[:]) <= np.abs(numbers.astype(np.float32)))
    assert bits[-2] == INFINITE


@pytest.mark.parametrize("n", SIZES, ids=str)
@pytest.mark.parametrize("s", [1.0, 0.5, 0.0])
@pytest.mark.parametrize("excess", [0.0, 0.3])
def test_update(random, n, s, excess):
    """New state, sums, and the restriction of p and x on F, of a part of p on A and of the indicator of A; one or several passes."""
    for longest in (n[0], 2):
        grid = Grid(n)
        levels_of = Multilevel(grid, HalfSpace(), np.float64, longest)
        if levels_of.levels[0].n == levels_of.levels[1].n:
            return
        g, p, d = state(random, n)
        x = random.standard_normal(n)
        d[g > 1] = INFINITE
        e = np.maximum(Widened(d)[:], -g)
        new_g, new_p = g + s * e, p + s * x
        work = np.zeros((7, n[1] + 1))
        sums = []
        for k, (i0, i1) in enumerate(levels_of.passes):
            sums.append(levels_of.update_rows(k, g, p, d[i0:i1], x[i0:i1].copy(), s, work, excess))
        closed = (new_g <= 0) & (new_p > 0)
        free = ~closed
        assert np.allclose(g, new_g)
        assert np.allclose(p, new_p)
        wanted = [np.sum(new_p[free] ** 2), np.sum(new_p**2), np.sum((new_p * e)[free]), np.sum((x * e)[free]),
                  np.sum((new_p * x)[free]), closed.sum(), new_g.sum(),
                  np.sum(closed & (new_p + s * x <= 0)), np.sum((new_g > 0) & (new_g + s * e <= 0))]
        assert np.sum(sums, axis=0) == pytest.approx(np.array(wanted), rel=1e-11, abs=1e-11)
        m = levels_of.levels[1].n
        found = np.zeros((3, *m))
        for row in range(levels_of.fields[0].shape[1]):
            found[:, (row - 1) % m[0]] += levels_of.fields[0][:, row]
        factor = m[0] * m[1] / (n[0] * n[1])
        P_x, P_y = interpolation(n[0], m[0]), interpolation(n[1], m[1])
        for field, fine in zip(found, (new_p * (free + excess * closed), 1.0 * closed, x * free), strict=True):
            assert np.allclose(field, factor * P_x.T @ fine @ P_y, atol=1e-12)
