"""Exact solutions made to order: choose p >= 0 and g >= 0 with disjoint supports, and build the
heights that have them."""

import numpy as np
import pytest
from contacts import EXACT, relative

import hpc_gfmd

GRIDS = [
    ((48, 48), (1.0, 1.0)),
    ((37, 50), (1.0, 1.7)),
    ((31, 31), (2.0, 2.0)),
    ((1, 64), (1.0, 1.0)),
    ((64, 1), (1.0, 1.0)),
    ((101, 12), (1.0, 0.2)),
]


def manufactured(n, sizes, seed=0):
    """Heights, E*, and their exact pressure and gap; smooth where they are positive, about a third
    of the points in contact."""
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(np.arange(n[0]) / n[0], np.arange(n[1]) / n[1], indexing="ij")
    s = np.zeros(n)
    for _ in range(6):
        k, phase = rng.integers(-3, 4, 2) * (np.array(n) > 1), rng.uniform(0, 2 * np.pi)
        s += rng.standard_normal() * np.cos(2 * np.pi * (k[0] * x + k[1] * y) + phase)
    k = int(0.6 * s.size)
    s -= np.sort(s, axis=None)[k : k + 2].mean()  # no point is at zero
    p, g = np.maximum(s, 0), 0.05 * np.maximum(-s, 0)
    E_star = 3.0
    q = np.hypot(
        2 * np.pi * np.fft.fftfreq(n[0], sizes[0] / n[0])[:, None],
        2 * np.pi * np.fft.fftfreq(n[1], sizes[1] / n[1]),
    )
    q[0, 0] = np.inf
    u = np.fft.ifft2(np.fft.fft2(p - p.mean()) * 2 / (E_star * q)).real
    return u - g, E_star, p, g  # z = u - g up to a constant


@pytest.mark.parametrize(("n", "sizes"), GRIDS)
@pytest.mark.parametrize("seed", [0, 1])
def test_exact(n, sizes, seed):
    z, E_star, p, g = manufactured(n, sizes, seed)
    found = hpc_gfmd.solve(z, p.mean(), E_star, sizes, **EXACT | {"residual": 1e-12})
    assert found.status == "converged"
    assert relative(found.pressure, p) < 1e-10
    assert relative(found.gap, g) < 1e-10
    assert found.a_r == np.mean(p > 0)
    assert found.gap_mean == pytest.approx(g.mean(), rel=1e-10)
