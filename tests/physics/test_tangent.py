"""The stiffness -dp/d(mean gap) against dense linear algebra, differences of solves, and limits."""

import numpy as np
import oracle
import pytest
from contacts import EXACT, random_heights, rough, solve_scene, sweep_of, sweep_over

from hpc_gfmd.bodies.halfspace import HALF_SPACE
from hpc_gfmd.contact import all_observables
from hpc_gfmd.operators import tangent as tangent_module
from hpc_gfmd.operators.tangent import tangent
from hpc_gfmd.parallel.grid import Grid
from hpc_gfmd.solvers import solver_names

SURFACE = rough(seed=7)
stiffness, conductance = (all_observables()[name] for name in ("stiffness", "conductance"))


def contacts():
    """Yield sets of contact points on grids of all shapes: scattered, in patches, a single point,
    all but one, a line, a profile."""
    rng = np.random.default_rng(3)
    for n in ((2, 5), (9, 9), (16, 22), (25, 13), (40, 1)):
        for share in (0.02, 0.2, 0.6, 0.95):
            yield rng.random(n) < share
            yield (z := random_heights(n, rng.integers(99))) > np.quantile(z, 1 - share)
        single = np.zeros(n, bool)
        single[n[0] // 2, n[1] // 3] = True
        yield from (single, ~single)
    line = np.zeros((24, 20), bool)
    line[:, 7] = True
    yield line


@pytest.mark.parametrize("sizes", [(1.0, 1.0), (1.0, 0.3)])
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_dense_oracle(dtype, sizes):
    """Errors are within the requested accuracy and within the estimate."""
    rounding = 1e-12  # of the oracle
    count = 0
    for contact in contacts():
        if contact.all() or not contact.any():
            continue
        grid = Grid(contact.shape, sizes)
        expected = oracle.compliance(contact, sizes) / grid.a
        for accuracy in (1e-2, 1e-3, 1e-6, 1e-12):
            result = tangent(grid, HALF_SPACE, contact, dtype, accuracy)
            error = abs(result.compliance / expected - 1)
            assert error < max(accuracy, 16 * np.finfo(dtype).eps) + rounding
            assert error < result.error + rounding
            assert result.pairs <= 6 - 2 * np.log10(accuracy)
        count += 1
    assert count > 40


@pytest.mark.parametrize("p_star", [0.01, 0.1, 0.6])
@pytest.mark.parametrize(
    ("name", "boundary"),
    [
        *[(name, "periodic") for name in solver_names()],
        ("bpx", "free"),
        ("bpx", ["free", "periodic"]),
    ],
)
def test_difference_of_solves(name, boundary, p_star):
    """Between loads so close that no point changes sides the gap is linear; units of the scene."""
    surface = rough((1, 16, 2), seed=2, g_rms=0.3, physical_sizes=[2.0, 2.0], boundary=boundary)
    sweep = sweep_of(surface, 5.0, **EXACT | {"residual": 1e-10})
    p = p_star * 5.0 * sweep.surface.g_rms
    below, above = (sweep.solve(q) for q in (p * (1 - 1e-5), p * (1 + 1e-5)))
    contact = solve_scene(surface, p_star, 5.0, name=name, residual=1e-6, precision="double")
    assert below.contact_points == contact.contact_points == above.contact_points
    assert stiffness(contact) == pytest.approx(
        2e-5 * p / (below.gap_mean - above.gap_mean), rel=2e-4
    )


def test_ends_of_the_load_curve():
    """Contacts of one point and of none."""
    top = solve_scene({"kind": "sphere", "radius": 1.0, "n": [32, 32]}, 1e-6, **EXACT)
    assert top.contact_points == 1
    point = np.zeros((32, 32), bool)
    point[0, 0] = True
    assert stiffness(top) == pytest.approx(1 / oracle.compliance(point), rel=1e-8)
    assert (
        tangent(Grid((8, 8)), HALF_SPACE, np.zeros((8, 8), bool), np.float64, 1e-3).compliance
        == np.inf
    )


@pytest.mark.parametrize(
    "discs", [[(0.5, 0.5, 0.2)], [(0.3, 0.3, 0.1), (0.7, 0.6, 0.15), (0.3, 0.8, 0.05)]]
)
def test_conductance_of_discs(discs):
    """Each disc conducts Holm's 2 k a, reduced by its neighbours (Greenwood 1966).

    In a periodic cell the images reduce it, too (Bonsall and Maradudin's sums over the square
    lattice). The contact of flat discs stays the same, so the approach is proportional to the load.
    """
    n = 192
    x = (np.arange(n) + 0.5) / n
    inside = [np.hypot(x[:, None] - X, x - Y) < a for X, Y, a in discs]
    z = np.where(np.any(inside, axis=0), 0.0, -1.0)
    free, periodic = (
        sweep_over(z, free=ends, E_star=5.0, accuracy=1e-6).solve(0.01)
        for ends in ((True, True), (False, False))
    )
    X, Y, a = np.transpose(discs)
    away = np.hypot(X[:, None] - X, Y[:, None] - Y)
    R = np.diag(1 / (2 * a)) + np.divide(1, np.pi * away, out=0 * away, where=away > 0)
    assert conductance(free) == pytest.approx(np.linalg.inv(R).sum(), rel=8e-3)
    assert conductance(free) == pytest.approx(0.002 / free.approach, rel=1e-5)
    assert conductance(periodic) == pytest.approx(stiffness(periodic) / 5.0)
    if len(discs) == 1:
        R = 1 / (2 * a[0]) - 3.900265 / np.pi + 9.0336 / (3 * np.pi) * a[0] ** 2
        assert conductance(periodic) == pytest.approx(1 / R, rel=1.2e-2)


def test_conductance_of_hertz():
    """It is 2 k a for a circle; a strip and a layer have none."""
    ball = {"kind": "sphere", "radius": 10.0, "n": [256, 256], "physical_sizes": [2.0, 2.0]}
    sweep = sweep_of(ball | {"boundary": "free"}, accuracy=1e-4)
    contact = sweep.solve(4 / 30 * 0.5**3 / 4)
    assert conductance(contact) == pytest.approx(2 * 0.5 / 4, rel=4e-3)
    strip = sweep_of(SURFACE | {"boundary": ["free", "periodic"]}, accuracy=1e-2).solve(0.1)
    layer = sweep_of(SURFACE, layer={"thickness": 0.1, "nu1": 0.3}, accuracy=1e-2).solve(0.1)
    assert conductance(strip) is conductance(layer) is None


def test_no_stiffness_if_the_iteration_fails(monkeypatch):
    contact = solve_scene(SURFACE, 0.05, accuracy=1e-3)
    monkeypatch.setattr(tangent_module, "MAX_STEPS", 3)
    assert stiffness(contact) is None


def test_its_fft_pairs_are_counted():
    contact = solve_scene(SURFACE, 0.05, accuracy=1e-3)
    before = contact.fft_pairs
    assert stiffness(contact) > 0
    assert 3 <= contact.fft_pairs - before <= 8
