"""Every solver against independent solutions: dense linear algebra, manufactured solutions and the
active sets of the campaign."""

import numpy as np
import oracle
import pytest
from campaign.truth import Contact
from contacts import EXACT, random_heights, relative, rough_wall, wave_numbers
from transfers import matrix

import hpc_gfmd
from hpc_gfmd.bodies.halfspace import HALF_SPACE
from hpc_gfmd.parallel.grid import Grid
from hpc_gfmd.solvers import solver_names

GRIDS = [
    ((8, 8), (1.0, 1.0)),
    ((9, 7), (1.0, 1.0)),
    ((12, 16), (2.0, 0.5)),
    ((1, 20), (1.0, 1.0)),
    ((16, 16), (1.0, 1.0)),
    ((5, 13), (1.0, 3.0)),
]
ODD = [(12, 11), (1, 16), (16, 1), (5, 7), (2, 2), (3, 1), (32, 3)]


def test_oracle_satisfies_its_equations():
    z = random_heights((10, 9))
    exact = oracle.solve(z, 0.4, 2.0, (1.0, 1.5))
    K = oracle.stiffness(z.shape, (1.0, 1.5), 2.0)
    p = 0.4 + K @ exact.displacement.ravel()
    assert np.abs(p - exact.pressure.ravel()).max() < 1e-12 * p.max()
    assert exact.gap.min() == 0
    assert not (exact.gap * exact.pressure).any()
    assert exact.pressure.mean() == pytest.approx(0.4, rel=1e-12)


@pytest.mark.parametrize(
    ("n", "sizes"), [*GRIDS, ((2, 2), (1.0, 3.0)), ((13, 1), (1.0, 1.0)), ((17, 23), (3.0, 3.0))]
)
def test_stiffness(n, sizes):
    """K agrees column by column, also for the shortest wave of an even number of points."""
    expected = oracle.stiffness(n, sizes) * Grid(n, sizes).a
    assert np.abs(matrix(HALF_SPACE, Grid(n, sizes)) - expected).max() < 1e-12


def assert_exact(solution, exact, tolerance):
    """Compare a solution with the exact one; displacements may differ by a constant."""
    assert solution.status == "converged"
    assert solution.a_r == exact.a_r
    assert solution.gap_mean == pytest.approx(exact.gap_mean, rel=tolerance)
    assert relative(solution.pressure, exact.pressure) < tolerance
    assert relative(solution.gap, exact.gap) < tolerance
    difference = solution.displacement - exact.displacement
    z = exact.displacement - exact.gap
    assert np.abs(difference - difference.mean()).max() < tolerance * np.ptp(z)


@pytest.mark.parametrize("load", [0.03, 0.4, 2.0])
@pytest.mark.parametrize(
    ("name", "n", "sizes", "tolerance"),
    [
        *[("bpx", n, sizes, 1e-10) for n, sizes in GRIDS],
        *[(name, n, (1.0, 1.0), 1e-7) for name in solver_names() for n in ODD],
    ],
)
def test_every_solver(name, n, sizes, tolerance, load):
    z = random_heights(n, seed=sum(n))
    exact = oracle.solve(z, load, 2.0, sizes)
    solution = hpc_gfmd.solve(
        z, load, 2.0, sizes, **EXACT | {"name": name, "residual": 1e-2 * tolerance}
    )
    assert_exact(solution, exact, tolerance)


def manufactured(n, sizes, seed=0):
    """Return heights and their exact solution, which is chosen first.

    p >= 0 and g >= 0 have disjoint supports and are smooth where they are positive; two fifths of
    the points are in contact.
    """
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(np.arange(n[0]) / n[0], np.arange(n[1]) / n[1], indexing="ij")
    s = np.zeros(n)
    for _ in range(6):
        k = rng.integers(-3, 4, 2) * (np.array(n) > 1)
        phase = rng.uniform(0, 2 * np.pi)
        s += rng.standard_normal() * np.cos(2 * np.pi * (k[0] * x + k[1] * y) + phase)
    n_open = int(0.6 * s.size)
    s -= np.sort(s, axis=None)[n_open : n_open + 2].mean()  # no point is at zero
    p = np.maximum(s, 0)
    g = 0.05 * np.maximum(-s, 0)
    q = wave_numbers(n, sizes)
    q[0, 0] = np.inf
    u = np.fft.ifft2(np.fft.fft2(p - p.mean()) * 2 / (3.0 * q)).real
    return u - g, oracle.Oracle(p, g, u, np.mean(p > 0), g.mean(), np.nan)


@pytest.mark.parametrize(
    ("n", "sizes"),
    [
        ((48, 48), (1.0, 1.0)),
        ((37, 50), (1.0, 1.7)),
        ((31, 31), (2.0, 2.0)),
        ((1, 64), (1.0, 1.0)),
        ((64, 1), (1.0, 1.0)),
        ((101, 12), (1.0, 0.2)),
    ],
)
@pytest.mark.parametrize("seed", [0, 1])
def test_manufactured_solution(n, sizes, seed):
    z, exact = manufactured(n, sizes, seed)
    solution = hpc_gfmd.solve(
        z, exact.pressure.mean(), 3.0, sizes, boundary="periodic", **EXACT | {"residual": 1e-12}
    )
    assert_exact(solution, exact, 1e-10)


@pytest.mark.parametrize(
    ("load", "hardness", "yields"),
    [(0.05, 1e9, 0.0), (0.05, 0.6, 0.03), (0.05, 0.3, 0.1), (0.2, 0.5, 0.29), (0.4, 0.402, 0.9)],
)
def test_with_a_hardness(load, hardness, yields):
    """p = 0 where the gap is open, and p = hardness in dents; a huge hardness changes nothing."""
    surface = rough_wall((2, 16, 2), hurst=0.9)
    exact = oracle.solve_yielding(surface.heights, load, hardness)
    solution = hpc_gfmd.solve(
        surface,
        load,
        hardness=hardness,
        **EXACT,
        fields=["pressure", "gap", "plastic", "displacement"],
    )
    assert solution.status == "converged"
    assert solution.a_r == exact.a_r
    assert solution.value("a_plastic") == np.mean(exact.gap < 0) >= yields
    assert solution.gap_mean == pytest.approx(exact.gap_mean, rel=1e-9)
    assert solution.value("energy") == pytest.approx(exact.energy, rel=1e-9)
    assert relative(solution.pressure, exact.pressure) < 1e-9
    assert relative(solution.gap - solution.plastic, exact.gap) < 1e-9
    assert relative(solution.displacement - solution.plastic, exact.displacement) < 1e-9
    assert solution.gap.min() == 0
    assert solution.pressure.max() <= hardness
    assert not (solution.gap * solution.pressure).any()
    if not yields:
        elastic = hpc_gfmd.solve(surface, load, **EXACT)
        assert relative(solution.pressure, elastic.pressure) < 1e-12
        assert solution.fft_pairs == elastic.fft_pairs
    for accuracy in (1e-2, 1e-5):
        solution_to_accuracy = hpc_gfmd.solve(surface, load, hardness=hardness, accuracy=accuracy)
        area, gap, pressure = solution_to_accuracy.errors
        assert max(solution_to_accuracy.errors) < accuracy
        assert abs(solution_to_accuracy.a_r - exact.a_r) <= area * exact.a_r
        assert abs(solution_to_accuracy.gap_mean - exact.gap_mean) <= gap * exact.gap_mean
        assert relative(solution_to_accuracy.pressure, exact.pressure) <= pressure


@pytest.mark.parametrize("name", solver_names())
@pytest.mark.parametrize(("n", "p_star"), [((64, 64), 0.02), ((96, 80), 0.2), ((64, 128), 0.8)])
def test_on_grids_with_many_levels(name, n, p_star):
    """Active sets of pressures, too large for dense matrices."""
    z = 1e-3 * random_heights(n, seed=n[1])
    reference = Contact(z, (1.0, 1.0))
    exact = reference.solve(p_star)
    load = p_star * reference.g_rms
    solution = hpc_gfmd.solve(z, load, name=name, residual=1e-10, precision="double")
    assert exact.kkt < 1e-10
    assert solution.status == "converged"
    assert round(solution.a_r * z.size) == exact.contact
    assert solution.gap_mean == pytest.approx(exact.gap_mean * reference.height_unit, rel=1e-7)
    assert relative(solution.pressure, exact.pressure * reference.g_rms) < 1e-7
    assert relative(solution.gap, exact.gap * reference.height_unit) < 1e-7
