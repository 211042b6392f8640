"""The passes of the default solver against NumPy."""

import numpy as np
import pytest
from sides import sides
from transfers import SIZES, interpolated, restricted, whole

from hpc_gfmd.bodies.halfspace import HalfSpace
from hpc_gfmd.kernels import bpx
from hpc_gfmd.kernels.bfloat16 import Decoded, encoded
from hpc_gfmd.operators.elastic import reader
from hpc_gfmd.operators.multilevel import Multilevel
from hpc_gfmd.parallel.grid import Grid

with_and_without_hardness = pytest.mark.parametrize("hardness", [None, 0.4])


def state(random, n, hardness, dtype=float):
    """Random g, p and encoded last step d; with a hardness some points have a dent, g < 0."""
    g = random.standard_normal(n).astype(dtype)
    g[(g < 0) & ((g > -1) | (hardness is None))] = 0
    p = random.standard_normal(n).astype(dtype)
    d = encoded(random.standard_normal(n) * (g != 0), dtype)
    return g, p, d


@pytest.mark.parametrize("n", SIZES)
@with_and_without_hardness
@pytest.mark.parametrize("coupling", [0.0, 1.1])
@pytest.mark.parametrize(
    ("dtype", "rough", "rounding"), [(np.float64, 1e-7, 1e-12), (np.float32, 1 / 128, 1e-4)]
)
def test_projected_step(random, n, coupling, hardness, dtype, rough, rounding):
    g, p, d = state(random, n, hardness, dtype)
    transfer, m = whole(n)
    z_coarse = random.standard_normal(m)
    padded = z_coarse[np.arange(-1, m[0] + 1) % m[0]].copy()
    a = 0.7
    b = -0.2
    compliance = 0.6
    closed, yields, r = sides(g, p, hardness)
    z = compliance * (r + coupling * interpolated(z_coarse, n))
    d[g > 1] = clipped_of(dtype)  # clipped in the last step: counts as no step now
    last_step = np.where(g > 1, 0, Decoded(d)[:]).astype(float)
    v = g - a * z - b * last_step
    through = a * compliance * (hardness or np.inf)
    opens = np.maximum(v, 0) + np.minimum(v + through, 0)
    dents = np.minimum(v, 0) + np.maximum(v - through, 0)
    wanted = np.where(closed, 0, np.where(yields, dents, opens) - g)
    x = np.empty(n, dtype)
    work = tuple(np.zeros((2, n[1] + 1), dtype))
    step = tuple(dtype(number) for number in (a, b, coupling, compliance))
    limit = hardness and dtype(hardness)
    work_of_solver, deeper = bpx.projected_step(
        g, p, d, x, 0, n[0], padded.astype(dtype), transfer.tables, step, limit, n, work
    )
    assert np.allclose(x, wanted, rtol=rough, atol=rounding)
    clipped = (wanted == -g) & ~closed
    assert np.array_equal(x[clipped], -g[clipped])  # to the bit
    # the same step after decoding
    assert np.array_equal(np.where(np.isinf(Decoded(d)[:]), -g, Decoded(d)[:]), x)
    assert hardness or np.all(g + x >= 0)
    grown = np.sum(np.maximum(-(g + x), 0) - np.maximum(-g, 0), dtype=float)
    work_done = np.vdot(p.astype(float), x) + (hardness or 0) * grown
    assert work_of_solver == pytest.approx(work_done, abs=10 * rounding)
    assert deeper == pytest.approx(grown, abs=10 * rounding)


def clipped_of(dtype):
    """The encoded minus infinity, which marks a clipped step."""
    return encoded([-np.inf], dtype)[0]


@pytest.mark.parametrize("n", SIZES)
@with_and_without_hardness
@pytest.mark.parametrize("s", [1.0, 0.5, 0.0])
def test_update(random, n, hardness, s):
    """New state, sums, and restrictions of p and x on free points and of the contact, in one or
    several passes."""
    for longest in (n[0], 2):
        grid = Grid(n)
        levels_of = Multilevel(grid, HalfSpace(), np.float64, longest)
        if levels_of.hierarchy.levels[0].n == levels_of.hierarchy.levels[1].n:
            return
        g, p, d = state(random, n, hardness)
        x = random.standard_normal(n)
        d[g > 1] = clipped_of(float)
        e = np.where(d == clipped_of(float), -g, d)
        new_g = g + s * e
        new_p = p + s * x
        fft = grid.fft(np.float64)
        fft.forward_rows(reader(x / n[1]))  # transformed back by rows alone
        sums = levels_of.update(g, p, d, s, fft.rows, hardness)
        closed, yields, r = sides(new_g, new_p, hardness)
        free = ~closed
        assert np.allclose(g, new_g)
        assert np.allclose(p, new_p)
        wanted = [
            np.sum(r[free] ** 2),
            np.sum(r**2) + np.sum(yields) * (hardness or 0) ** 2,
            np.sum((r * e)[free]),
            np.sum((x * e)[free]),
            np.sum((r * x)[free]),
            np.sum(closed | yields),
            new_g[~yields].sum(),
            yields.sum(),
            0.0,  # no attraction
            0.0,
        ]
        assert np.array(sums) == pytest.approx(np.array(wanted), rel=1e-11, abs=1e-11)
        m = levels_of.hierarchy.levels[1].n
        restricted_fields = np.zeros((3, *m))
        for row in range(levels_of.fields[0].shape[1]):
            restricted_fields[:, (row - 1) % m[0]] += levels_of.fields[0][:, row]
        for field, fine in zip(restricted_fields, (r * free, 1.0 * closed, x * free), strict=True):
            assert np.allclose(field, restricted(fine, m), atol=1e-12)
