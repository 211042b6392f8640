"""The start on a finer grid: interpolation and local relaxation."""

import numpy as np
import pytest

from hpc_gfmd.kernels import prolong


def prolonged(u, p, h, steps, stencil, parts=1, hardness=np.inf):
    """The gap by prolong_gap from coarse fields u, p on the grid of h, in `parts` slabs."""
    n_x, n_y = h.shape
    m_x, m_y = u.shape
    step = 2 if m_x != n_x else 1
    bounds = np.linspace(0, n_x, parts + 1).astype(int)
    out = []
    for start, stop in zip(bounds, bounds[1:]):
        first_coarse = -(-start // step)
        last_coarse = -(-stop // step)

        def cut(a, i, k, width):
            return tuple(
                np.take(a, np.arange(*r), axis=0, mode="wrap")
                for r in ((i - width, i), (i, k), (k, k + width))
            )

        g = np.empty((stop - start, n_y))
        coarse = [cut(a, first_coarse, last_coarse, prolong.HALO) for a in (u, p)]
        prolong.prolong_gap(
            *coarse,
            cut(h, start, stop, prolong.SWEEPS),
            g,
            (start, n_x),
            (first_coarse, m_x),
            (m_x != n_x, m_y != n_y),
            steps,
            stencil,
            hardness,
            h.shape,
        )
        out.append(g)
    return np.concatenate(out)


def interpolated(a, n, near, far):
    """Rows of a at even positions, weighted means of four rows between them.

    near: weight of the two nearest rows; far: of the two rows beyond.
    """
    if len(a) == n:
        return a
    between = near * (a + np.roll(a, -1, 0)) + far * (np.roll(a, 1, 0) + np.roll(a, -2, 0))
    return np.stack([a, between], 1).reshape(-1, a.shape[1])[:n]


@pytest.mark.parametrize(
    ("n", "m"),
    [
        ((32, 48), (16, 24)),
        ((33, 47), (17, 24)),
        ((31, 20), (31, 10)),
        ((24, 31), (12, 31)),
        ((12, 2), (6, 2)),
        ((10, 1), (5, 1)),
    ],
)
@pytest.mark.parametrize("hardness", [np.inf, 0.4])
def test_local_relaxation(random, n, m, hardness):
    """prolong_gap follows its formula in any number of slabs.

    Gaps are never negative, and 0 where heights would penetrate.
    """
    u = random.standard_normal(m)
    p = random.standard_normal(m)
    h = random.standard_normal(n)
    stencil = np.array([1.2, -0.3, -0.2, -0.04])
    steps = [0.9, 0.7, 0.5]
    w = interpolated(interpolated(u, n[0], 9 / 16, -1 / 16).T, n[1], 9 / 16, -1 / 16).T + h
    P = interpolated(interpolated(p, n[0], 0.5, 0.0).T, n[1], 0.5, 0.0).T

    def projected(v, c):
        return np.maximum(v, np.minimum(v + c * hardness, -w))

    v = projected(np.zeros(n), steps[0])
    for c in steps:
        rows = np.roll(v, 1, 0) + np.roll(v, -1, 0)
        columns = np.roll(v, 1, 1) + np.roll(v, -1, 1)
        v = projected(
            v
            - c
            * (
                P
                + stencil[0] * v
                + stencil[1] * rows
                + stencil[2] * columns
                + stencil[3] * (np.roll(rows, 1, 1) + np.roll(rows, -1, 1))
            ),
            c,
        )
    g = prolonged(u, p, h, steps, stencil, hardness=hardness)
    assert np.allclose(g, w + v, atol=1e-13)
    assert np.isfinite(hardness) or g.min() == 0
    assert (g == 0).any()
    for parts in (2, 3, 5):
        assert np.array_equal(prolonged(u, p, h, steps, stencil, parts, hardness), g)


def test_gradient_steps_reduce_all_waves_that_the_coarse_grid_lacks():
    """By the least factor that so many steps have in common, 1/T_3 of the range of K."""
    stencil = np.array([0.765, -0.138, -0.13, -0.025])
    steps = prolong.gradient_steps(stencil, (True, True))
    assert steps == sorted(steps, reverse=True)
    x, y = np.cos(np.meshgrid(np.linspace(0, np.pi, 201), np.linspace(0, np.pi, 201)))
    symbol = stencil @ [np.ones_like(x).ravel(), 2 * x.ravel(), 2 * y.ravel(), 4 * (x * y).ravel()]
    symbol = symbol[(np.minimum(x, y) <= 1e-12).ravel()]
    left = np.abs(np.prod([1 - c * symbol for c in steps], axis=0)).max()
    middle = (symbol.max() + symbol.min()) / (symbol.max() - symbol.min())
    assert left == pytest.approx(1 / np.cosh(prolong.SWEEPS * np.arccosh(middle)), rel=1e-6)
