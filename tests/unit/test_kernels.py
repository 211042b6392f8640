"""Kernels against what they mean, written down once more in NumPy."""

import numpy as np
import pytest

from hpc_gfmd.bodies.halfspace import HalfSpace
from hpc_gfmd.grid import Grid
from hpc_gfmd.kernels import bpx, certify, multilevel, prolong, spectral, surface
from hpc_gfmd.operators.coarsening import Transfer, levels, owned_rows
from hpc_gfmd.operators.multilevel import COUPLING, DAMPING, Multilevel

SIZES = [(8, 8), (9, 9), (8, 6), (12, 7), (5, 16), (1, 16), (16, 1), (2, 2), (3, 5), (4, 32), (17, 33), (1, 1)]


def interpolation(n, m):
    """The matrix of linear interpolation from m to n points of a periodic axis; coarse point J at J n/m."""
    P = np.zeros((n, m))
    for i in range(n):
        J, f = i * m // n, (i * m % n) / n
        P[i, J] += 1 - f
        P[i, (J + 1) % m] += f
    return P if n != m else np.eye(n)


@pytest.fixture
def random():
    return np.random.default_rng(5)


# ---- spectra ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("edges", [[0, 4, 8, 12, 13], [0, 13], [0, 5, 9, 13, 13]], ids=str)
def test_blocks(random, edges):
    rows = random.standard_normal((3, 13)) + 1j
    edges, blocks, back = np.array(edges), np.zeros(7 * 13, complex), np.zeros((3, 13), complex)
    spectral.to_blocks(rows, blocks, edges, 7, 2, 3)
    whole = np.concatenate([blocks[7 * a:7 * b].reshape(7, b - a) for a, b in zip(edges, edges[1:])], axis=1)
    assert np.array_equal(whole[2:5], rows)
    assert not whole[:2].any()
    assert not whole[5:].any()
    spectral.from_blocks(blocks, back, edges, 7, 2, 3)
    assert np.array_equal(back, rows)


@pytest.mark.parametrize("cuts", [[0, 24], [0, 9, 9, 24], [8, 16, 0, 8, 16, 24]], ids=["whole", "ranks", "in another order"])
@pytest.mark.parametrize("width", [8, 5, 1])
def test_transpose(random, width, cuts):
    """Of a block whose rows are in pieces, somewhere in memory."""
    block, columns = random.standard_normal((24, width)), np.empty((width, 24))
    rows = np.array(list(zip(cuts, cuts[1:])) if cuts[0] == 0 else np.reshape(cuts, (-1, 2)))
    first = 3 + 2 * np.arange(len(rows)) + np.cumsum([0, *np.diff(rows)[:-1, 0]]) * width
    memory, back = np.full(200, np.nan), np.full(200, np.nan)
    for start, (i0, i1) in zip(first, rows, strict=True):
        memory[start:start + (i1 - i0) * width] = block[i0:i1].ravel()
    spectral.transpose(memory, first, rows, columns)
    assert np.array_equal(columns, block.T)
    spectral.transpose_back(columns, back, first, rows)
    assert np.array_equal(back, memory, equal_nan=True)


@pytest.mark.parametrize(("kernel", "power"), [(spectral.multiply_stiffness, 1), (spectral.multiply_compliance, -1)])
def test_multiply(random, kernel, power):
    n_x = 5 + spectral.PIECE  # more than is summed up at once
    q_x, q_y, weight = np.repeat(random.standard_normal(n_x), 2), random.standard_normal(4), np.array([1.0, 2, 2, 0])
    q_x[:2] = q_y[0] = 0
    block = random.standard_normal((4, 2 * n_x))
    q = np.hypot(q_x, q_y[:, None])
    k = 0.3 * np.power(q, power, out=np.zeros_like(q), where=q > 0)
    before = block.copy()
    energy = kernel(block, q_x, q_y, weight, 0.3)
    assert energy == pytest.approx(np.sum(weight[:, None] * k * before**2), rel=1e-13)
    assert np.allclose(block, k * before, rtol=1e-14)


def test_spectrum_sums(random):
    q_x, q_y, weight = np.array([0, 1.0, -1]), np.array([0, 2.0]), np.array([1.0, 2])
    block = random.standard_normal((2, 3)) + 1j * random.standard_normal((2, 3))
    q2 = q_x**2 + q_y[:, None] ** 2
    power = weight[:, None] * np.abs(block) ** 2
    assert spectral.spectrum_sums(block, q_x, q_y, weight) == pytest.approx((power[q2 > 0].sum(), (q2 * power).sum()))


def test_random_spectrum_is_that_of_a_real_field():
    n = 8
    whole = np.zeros((n, n), complex)
    for k_y in range(n):
        block = np.zeros((1, n), complex)
        surface.self_affine(block, 0.0, 1.0, k_y if k_y <= n // 2 else k_y - n, 1, n, np.uint64(3), 1.0, 1.0, 4.0, 1.0, 1.8)
        whole[:, k_y] = block[0]
    heights = np.fft.ifft2(whole)
    assert np.abs(heights.imag).max() < 1e-14 * np.abs(heights.real).max()
    k = np.hypot(*np.meshgrid(np.fft.fftfreq(n, 1 / n), np.fft.fftfreq(n, 1 / n)))
    assert (np.abs(whole[(k >= 1) & (k <= 4)]) > 0).all()
    assert not whole[(k < 1) | (k > 4 + 1e-9)].any()


def test_random_numbers_are_uniform():
    """Real and imaginary parts over |k|^-(1+H) fill (-1, 1) evenly, and neighbouring seeds and modes are independent."""
    parts = []
    for seed in (0, 1):
        block = np.zeros((100, 256), complex)
        surface.self_affine(block, 0.0, 1.0, 1, 100, 512, np.uint64(seed), 1.0, 1.0, 300.0, 1.0, 0.0)
        block = block.T
        assert np.abs(block.real[:100]).max() < 1
        for part in (block.real[:100].ravel(), block.imag[:100].ravel()):
            assert np.mean(part) == pytest.approx(0, abs=0.03)
            assert np.mean(part**2) == pytest.approx(1 / 3, abs=0.02)
            parts.append(part)
    parts.append(np.roll(parts[0], 1))
    correlation = np.corrcoef(parts) - np.eye(len(parts))
    assert np.abs(correlation).max() < 0.05


# ---- contact ---------------------------------------------------------------------------------------------------------------


def state(random, n, dtype=float):
    g = np.maximum(random.standard_normal(n), 0).astype(dtype)
    p = random.standard_normal(n).astype(dtype)
    d = random.standard_normal(n).astype(dtype) * (g > 0)
    return g, p, d


def whole(n, dtype=float):
    """The transfer of a grid that one rank holds."""
    hierarchy = levels(Grid(n))
    m = hierarchy[1].n if len(hierarchy) > 1 else n
    t = Transfer(n, m, [0, n[0]], 0, dtype)
    return t, m, interpolation(n[0], m[0]), interpolation(n[1], m[1])


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
    wanted = np.where(closed, 0, np.maximum(g - a * z - b * d, 0) - g)
    x, work = np.empty(n), np.zeros((2, n[1] + 1))
    found = bpx.projected_step(g, p, d, x, (0, n[0]), padded, t.tables, (a, b, coupling, compliance), n, work)
    assert np.allclose(d, wanted, atol=1e-13)
    assert np.array_equal(d, x)
    assert found == pytest.approx(np.vdot(p, wanted), abs=1e-12)


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
        new_g, new_p = g + s * d, p + s * x
        work = np.zeros((7, n[1] + 1))
        sums = []
        for k, (i0, i1) in enumerate(levels_of.passes):
            sums.append(levels_of.update_rows(k, g, p, d, x[i0:i1].copy(), s, work, excess))
        closed = (new_g <= 0) & (new_p > 0)
        free = ~closed
        assert np.allclose(g, new_g)
        assert np.allclose(p, new_p)
        wanted = [np.sum(new_p[free] ** 2), np.sum(new_p**2), np.sum((new_p * d)[free]), np.sum((x * d)[free]),
                  np.sum((new_p * x)[free]), closed.sum(), new_g.sum(),
                  np.sum(closed & (new_p + s * x <= 0)), np.sum((new_g > 0) & (new_g + s * d <= 0))]
        assert np.sum(sums, axis=0) == pytest.approx(np.array(wanted), rel=1e-11, abs=1e-11)
        m = levels_of.levels[1].n
        found = np.zeros((3, *m))
        for row in range(levels_of.fields[0].shape[1]):
            found[:, (row - 1) % m[0]] += levels_of.fields[0][:, row]
        factor = m[0] * m[1] / (n[0] * n[1])
        P_x, P_y = interpolation(n[0], m[0]), interpolation(n[1], m[1])
        for field, fine in zip(found, (new_p * (free + excess * closed), 1.0 * closed, x * free), strict=True):
            assert np.allclose(field, factor * P_x.T @ fine @ P_y, atol=1e-12)


# ---- levels ----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("n", SIZES, ids=str)
def test_transfers_are_adjoint(random, n):
    """<R x, y> N/N_1 = <x, P y>, and both are what they are called."""
    t, m, P_x, P_y = whole(n)
    x, y = random.standard_normal(n), random.standard_normal(m)
    fine, coarse = np.zeros((1, n[0] + 2, n[1])), np.zeros((1, m[0] + 2, m[1]))
    fine[0, 1:-1] = x
    multilevel.restrict_level(fine, coarse, t.tables)
    R = coarse[0, 1:-1].copy()
    R[0] += coarse[0, -1]
    R[-1] += coarse[0, 0]
    ratio = n[0] * n[1] / (m[0] * m[1])
    assert np.allclose(R, P_x.T @ x @ P_y / ratio, atol=1e-13)
    Py = np.zeros((1, n[0] + 2, n[1]))
    rt = np.zeros((2, n[0] + 2, n[1]))
    multilevel.smooth_level(rt, y[np.arange(-1, m[0] + 1) % m[0]].copy(), Py[0], 1.0, 4.0, 1.0, t.tables)
    assert np.allclose(Py[0, 1:-1], P_x @ y @ P_y.T, atol=1e-13)
    assert np.vdot(R, y) * ratio == pytest.approx(np.vdot(x, Py[0, 1:-1]), abs=1e-12)


@pytest.mark.parametrize("sizes", [(1.0, 1.0), (1.0, 3.0)])
@pytest.mark.parametrize("n", SIZES, ids=str)
def test_hierarchy(n, sizes):
    hierarchy = levels(Grid(n, sizes))
    assert hierarchy[0].n == n
    assert hierarchy[0].q == pytest.approx(Grid(n, sizes).q_nyquist, rel=1e-12)
    assert hierarchy[-1].n == (1, 1)
    for fine, coarse in zip(hierarchy, hierarchy[1:], strict=False):
        assert all(c in (f, (f + 1) // 2) for f, c in zip(fine.n, coarse.n, strict=True))
        assert coarse.n != fine.n
        assert 0 < coarse.q <= fine.q * 1.01


def test_every_coarse_row_has_one_owner():
    for n in range(1, 40):
        for size in (1, 2, 3, 4, 7):
            starts = Grid((n, 4)).starts if size == 1 else np.sort(np.random.default_rng(n).integers(0, n + 1, size - 1))
            starts = np.array([0, n]) if size == 1 else np.array([0, *starts, n])
            m = (n + 1) // 2
            owned = owned_rows(starts, n, m)
            assert owned[0] == 0
            assert owned[-1] == m
            assert (np.diff(owned) >= 0).all()


def by_matrices(grid, r, theta, level=0):
    """M' r by the recursion z_l = r_l/(weight_l + c theta_l) + w P z_(l+1), from a level on."""
    hierarchy = levels(grid)
    z = r / (HalfSpace().weights(grid)[level] + DAMPING * theta)
    if level + 1 < len(hierarchy):
        n, m = hierarchy[level].n, hierarchy[level + 1].n
        P_x, P_y = interpolation(n[0], m[0]), interpolation(n[1], m[1])
        ratio = n[0] * n[1] / (m[0] * m[1])
        z = z + COUPLING * P_x @ by_matrices(grid, P_x.T @ r @ P_y / ratio, P_x.T @ theta @ P_y / ratio, level + 1) @ P_y.T
    return z


def swept(grid, p, closed):
    """M' p on level 1 by the solver's own sweep, and the sum <p, M' p>."""
    sweep = Multilevel(grid, HalfSpace(), np.float64, max(grid.n[0], 1))
    g = np.where(closed, 0.0, 1.0)
    q = np.where(closed, 1.0, p)
    zero, work = np.zeros(grid.n), np.zeros((7, grid.n[1] + 1))
    for k in range(len(sweep.passes)):
        sweep.update_rows(k, g, q.copy(), zero.copy(), zero, 0.0, work)
    sums = sweep.sweep()
    return sweep.z[1:-1].copy(), sums[0]


@pytest.mark.parametrize("n", [n for n in SIZES if n != (1, 1)], ids=str)
def test_sweep(random, n):
    grid = Grid(n)
    closed = random.random(n) < 0.3
    p = np.where(closed, 0, random.standard_normal(n))
    m = levels(grid)[1].n
    P_x, P_y = interpolation(n[0], m[0]), interpolation(n[1], m[1])
    ratio = n[0] * n[1] / (m[0] * m[1])
    wanted = by_matrices(grid, P_x.T @ p @ P_y / ratio, P_x.T @ closed @ P_y / ratio, 1)
    found, energy = swept(grid, p, closed)
    assert np.allclose(found, wanted, atol=1e-12)
    assert energy == pytest.approx(np.vdot(p, P_x @ wanted @ P_y.T), abs=1e-11)


@pytest.mark.parametrize("sizes", [(1.0, 1.0), (1.0, 2.5)])
@pytest.mark.parametrize("n", [(8, 8), (7, 9), (6, 10), (1, 12), (5, 3)], ids=str)
def test_preconditioner_is_symmetric_positive_definite(random, n, sizes):
    """M = 1 + w P M' R on the free points, as a matrix."""
    grid = Grid(n, sizes)
    closed = random.random(n) < 0.3
    free = np.flatnonzero(~closed)
    m = levels(grid)[1].n
    P_x, P_y = interpolation(n[0], m[0]), interpolation(n[1], m[1])
    M = np.zeros((free.size, free.size))
    for column, i in enumerate(free):
        unit = np.zeros(n)
        unit.flat[i] = 1
        z, _ = swept(grid, unit, closed)
        M[:, column] = (unit + COUPLING * P_x @ z @ P_y.T).ravel()[free]
    assert np.abs(M - M.T).max() < 1e-12
    assert np.linalg.eigvalsh(M).min() >= 1 - 1e-9


def prolonged(u, p, h, compliance, stencil, parts=1):
    """prolong_gap of whole coarse fields u, p to the grid of h, in a number of slabs."""
    (n_x, n_y), (m_x, m_y) = h.shape, u.shape
    step = 2 if m_x != n_x else 1
    bounds = np.linspace(0, n_x, parts + 1).astype(int)
    out = []
    for start, stop in zip(bounds, bounds[1:]):
        first, last = -(-start // step), -(-stop // step)

        def cut(a, i, k, width):
            return tuple(np.take(a, np.arange(*r), axis=0, mode="wrap") for r in ((i - width, i), (i, k), (k, k + width)))

        g = np.empty((stop - start, n_y))
        coarse = [cut(a, first, last, prolong.HALO) for a in (u, p)]
        prolong.prolong_gap(*coarse, cut(h, start, stop, prolong.SWEEPS), g, (start, n_x), (first, m_x), (m_x != n_x, m_y != n_y),
                            compliance, stencil, h.shape)
        out.append(g)
    return np.concatenate(out)


def interpolated(a, n, near, far):
    """Rows of a at even places, and between them the mean of four rows with these weights (two of them the nearest)."""
    if len(a) == n:
        return a
    between = near * (a + np.roll(a, -1, 0)) + far * (np.roll(a, 1, 0) + np.roll(a, -2, 0))
    return np.stack([a, between], 1).reshape(-1, a.shape[1])[:n]


def test_interpolation_of_a_displacement():
    """Without contact cubic interpolation is all: exact for points on the coarse grid, and of fourth order between them."""
    errors = []
    for n in (32, 64):
        x = np.arange(n) / n
        u = np.cos(2 * np.pi * x)[:, None] * np.sin(2 * np.pi * x)
        coarse = u[::2, ::2].copy()
        g = prolonged(coarse, np.zeros_like(coarse), np.full((n, n), 10.0), 0.6, np.array([1.2, -0.2, -0.2, -0.04]))
        assert np.allclose(g[::2, ::2] - 10, coarse)
        errors.append(np.abs(g - 10 - u).max())
    assert errors[0] / errors[1] > 12


@pytest.mark.parametrize(("n", "m"), [((32, 48), (16, 24)), ((33, 47), (17, 24)), ((31, 20), (31, 10)), ((24, 31), (12, 31)),
                                      ((12, 2), (6, 2)), ((10, 1), (5, 1))])
def test_local_relaxation(random, n, m):
    """prolong_gap does what its formula says, in any number of slabs; its gap is never negative, and 0 where heights poke through."""
    u, p, h = random.standard_normal(m), random.standard_normal(m), random.standard_normal(n)
    stencil, compliance = np.array([1.2, -0.3, -0.2, -0.04]), 0.7
    w = interpolated(interpolated(u, n[0], 9 / 16, -1 / 16).T, n[1], 9 / 16, -1 / 16).T + h
    P = interpolated(interpolated(p, n[0], 0.5, 0.0).T, n[1], 0.5, 0.0).T
    v = np.maximum(-w, 0)
    for _ in range(prolong.SWEEPS):
        rows = np.roll(v, 1, 0) + np.roll(v, -1, 0)
        columns = np.roll(v, 1, 1) + np.roll(v, -1, 1)
        v = np.maximum(v - compliance * (P + stencil[0] * v + stencil[1] * rows + stencil[2] * columns
                                  + stencil[3] * (np.roll(rows, 1, 1) + np.roll(rows, -1, 1))), -w)
    g = prolonged(u, p, h, compliance, stencil)
    assert np.allclose(g, w + v, atol=1e-13)
    assert g.min() == 0
    for parts in (2, 3, 5):
        assert np.array_equal(prolonged(u, p, h, compliance, stencil, parts), g)


def test_stiffness_between_neighbours():
    """It is K in real space, by a direct sum over the wave vectors; axes without neighbours have none."""
    grid = Grid((64, 80), (1.0, 1.0))
    q = np.hypot(grid.q_x[:, None], 2 * np.pi * np.fft.fftfreq(80) * grid.a / grid.spacings[1])
    theta_x, theta_y = 2 * np.pi * np.fft.fftfreq(64)[:, None], 2 * np.pi * np.fft.fftfreq(80)
    wanted = [np.mean(0.5 * q * np.cos(i * theta_x) * np.cos(j * theta_y)) for i, j in ((0, 0), (1, 0), (0, 1), (1, 1))]
    assert HalfSpace().near(grid) == pytest.approx(wanted, abs=1e-4)
    assert (HalfSpace().near(Grid((64, 1)))[2:] == 0).all()
    assert (HalfSpace().near(Grid((2, 64)))[[1, 3]] == 0).all()


# ---- certificate -----------------------------------------------------------------------------------------------------------


def test_kkt_residuals(random):
    g = random.standard_normal((6, 5))
    g[g < 0.3] = np.minimum(g[g < 0.3], 0)
    x, p = random.standard_normal((6, 5)), np.empty((6, 5))
    sums, extremes = certify.kkt_residuals(g, p, x, 0.2, g.shape, 0, 6)
    fresh = 0.2 + x
    closed = (g <= 0) & (fresh > 0)
    wanted = (np.sum(fresh[~closed] ** 2), np.sum(fresh[~closed] ** 4), np.sum(fresh[closed] ** 2), np.sum(fresh[closed]),
              np.sum(np.abs(fresh) * g), closed.sum(), g.sum())
    assert np.array_equal(p, fresh)
    assert sums == pytest.approx(wanted, rel=1e-13)
    assert extremes == pytest.approx((max(-g.min(), 0), max((-fresh[g <= 0]).max(initial=0), 0)), rel=1e-13)
    assert certify.open_moments(g, p) == pytest.approx(wanted[:2], rel=1e-13)


def test_uncertain_points(random):
    g, p = np.maximum(random.standard_normal((40, 50)), 0), random.standard_normal((40, 50))
    takes = np.where(g > 0, g / 0.7, np.abs(p)) ** 2
    counts = np.zeros((2, certify.BINS))
    certify.count_uncertain(g, p, 0.7, 0.05, 0.1, 0.5, counts)
    edges = 0.5 * 2.0 ** (-np.arange(certify.BINS + 1) / certify.PER_OCTAVE)
    for side, found in zip((g <= 0, g > 0), counts, strict=True):
        t = takes[side & (takes >= 0.05**2) & (takes <= 0.5)]
        binned = t[t > 0.1**2]
        assert found[-1] == np.sum(t <= 0.1**2) > 0
        wanted = [np.sum((binned > low) & (binned <= high)) for high, low in zip(edges, edges[1:])]
        assert np.array_equal(found[:-1], wanted[:-1])


def test_dual_rows(random):
    g, p = np.maximum(random.standard_normal((4, 5)), 0), random.standard_normal((4, 5))
    x = np.empty((4, 5))
    total = certify.dual_rows(g, p, x, 1.5, g.shape, 0, 4)
    admissible = 1.5 * p * ((g <= 0) & (p > 0))
    assert np.allclose(x, admissible - p)
    assert total == pytest.approx(np.vdot(admissible, g), abs=1e-14)


def test_contact_edges(random):
    closed = random.random((7, 6)) < 0.5
    g, p = np.where(closed, 0.0, 1.0), np.ones((7, 6))
    wanted = tuple(np.sum(closed != np.roll(closed, 1, axis)) for axis in (1, 0))
    assert certify.contact_edges(g, p, g[0], p[0], True) == wanted
    parts = certify.contact_edges(g[:3], p[:3], g[3], p[3], True), certify.contact_edges(g[3:], p[3:], g[0], p[0], True)
    assert tuple(map(sum, zip(*parts, strict=True))) == wanted
