"""The paper's GFMD, FIRE and constrained conjugate gradients: their solutions, their options, and
what they cost."""

import numpy as np
import pytest
from contacts import random_heights, rough, surface_over, sweep_of

from hpc_gfmd.certificate.certificate import certify
from hpc_gfmd.driver.nested import cold_gap
from hpc_gfmd.kernels import ccg
from hpc_gfmd.kernels.dynamics import update_pressure, verlet_step
from hpc_gfmd.operators.problem import Problem
from hpc_gfmd.solvers import solver_class
from hpc_gfmd.util.errors import SceneError

KINDS = {
    "gfmd": ("gfmd", {}),
    "gfmd-constant": ("gfmd", {"damping": 1.0}),
    "fire": ("fire", {}),
    "ccg": ("ccg", {}),
    "ccg-preconditioned": ("ccg", {"preconditioned": 1}),
}
every_kind = pytest.mark.parametrize("kind", KINDS)
ROUGH = {"64": rough((2, 16, 2), seed=3), "128": rough((2, 16, 4), hurst=0.3, seed=4)}
WAVE = {"kind": "wave", "amplitude": 0.05, "n": [256, 4]}


def problem_of(surface, p0, dtype=np.float64):
    made = sweep_of(surface).surface
    return Problem(made.grid, made.h.astype(dtype), p0)


def solved(problem, name, options=None, residual=1e-9, most=4000):
    solver = solver_class(name)(problem, options or {})
    solver.start(cold_gap(problem))
    while solver.progress().residual > residual and solver.iterations < most:
        solver.step()
    return solver


def contact_pressure(solver):
    """From a fresh application of the operator, 0 out of contact."""
    p = np.empty(solver.g.shape)
    certificate = certify(solver.problem_now, solver.g, p)
    return np.where((solver.g <= 0) & (p > 0), p, 0), certificate


def assert_same(found, wanted, tolerance):
    p, certificate = contact_pressure(found)
    p_wanted, _ = contact_pressure(wanted)
    assert np.linalg.norm(p - p_wanted) <= tolerance * np.linalg.norm(p_wanted)
    assert np.linalg.norm(found.g - wanted.g) <= tolerance * max(
        np.linalg.norm(wanted.g), 1e-3 * np.linalg.norm(wanted.problem.h)
    )
    assert np.array_equal(p > 0, p_wanted > 0)
    assert found.progress().contact == wanted.progress().contact
    return certificate


@every_kind
@pytest.mark.parametrize("size", ROUGH)
def test_same_as_the_default_solver(kind, size):
    for p0 in (0.007, 0.05, 0.353, 1.0):
        problem = problem_of(ROUGH[size], p0)
        found, wanted = (
            solved(problem, *KINDS[kind]),
            solved(problem, "bpx", residual=1e-11, most=60),
        )
        certificate = assert_same(found, wanted, 1e-7)
        assert certificate.residual < 2e-9
        assert certificate.load_balance < 1e-8


@every_kind
@pytest.mark.parametrize("p_hat", [0.1, 0.5, 0.9])
def test_westergaard(kind, p_hat):
    problem = problem_of(
        WAVE, p_hat / np.sqrt(2)
    )  # p_full = pi E* A is std(p)/sqrt(1/2) = sqrt(1/2) E* g_rms
    assert problem.grid.n == (256, 1)
    found = solved(problem, *KINDS[kind])
    assert_same(found, solved(problem, "bpx", residual=1e-11, most=60), 1e-6)
    assert found.progress().contact / 256 == pytest.approx(
        2 / np.pi * np.arcsin(np.sqrt(p_hat)), abs=2.5 / 256
    )
    gap = (1 - p_hat + p_hat * np.log(p_hat)) * problem.h.max() / 2
    assert found.progress().gap_mean == pytest.approx(gap, rel=2e-3)


@pytest.mark.parametrize(
    "kind", [k for k in KINDS if k != "gfmd-constant"]
)  # far too much damping for the small load
@pytest.mark.parametrize("p0", [1e-4, 2.0])
def test_extreme_loads(kind, p0):
    problem = problem_of(ROUGH["64"], p0)
    assert_same(
        solved(problem, *KINDS[kind]), solved(problem, "bpx", residual=1e-11, most=60), 1e-5
    )


@every_kind
def test_odd_rectangle(kind):
    z = random_heights((45, 22), seed=5)
    made = surface_over(z, (1.0, 0.7))
    problem = Problem(made.grid, made.h, 0.05)
    assert_same(
        solved(problem, *KINDS[kind]), solved(problem, "bpx", residual=1e-11, most=60), 1e-7
    )


@every_kind
def test_single_precision(kind):
    problem = problem_of(ROUGH["64"], 0.05, np.float32)
    found = solved(problem, *KINDS[kind], residual=1e-4)
    assert found.g.dtype == found.p.dtype == np.float32
    _, certificate = contact_pressure(found)
    assert certificate.residual < 5e-4
    wanted = solved(problem_of(ROUGH["64"], 0.05), "bpx")
    assert found.progress().gap_mean == pytest.approx(wanted.progress().gap_mean, rel=1e-3)


@every_kind
def test_another_load_without_an_fft(kind):
    problem = problem_of(ROUGH["64"], 0.1)
    solver = solved(problem, *KINDS[kind])
    pairs = solver.pairs
    solver.continue_at(0.11)
    assert solver.pairs == pairs
    while solver.progress().residual > 1e-9:
        solver.step()
    assert_same(solver, solved(problem_of(ROUGH["64"], 0.11), "bpx", residual=1e-11, most=60), 1e-7)


@pytest.mark.parametrize(
    ("kind", "each"), [("gfmd", 1), ("fire", 1), ("ccg", 2), ("ccg-preconditioned", 3)]
)
def test_pairs_per_iteration(kind, each):
    name, options = KINDS[kind]
    solver = solver_class(name)(problem := problem_of(ROUGH["64"], 0.1), options)
    solver.start(cold_gap(problem))
    before = solver.pairs
    solver.step()
    assert solver.pairs == before + each


def test_measured_damping_beats_constant_damping():
    """At a low and at a high load, which need different constants."""
    for p0, constants in ((0.007, (1, 3)), (0.353, (1, 3, 6))):
        problem = problem_of(rough((2, 32, 2)), p0)
        measured = solved(problem, "gfmd", residual=1e-5).iterations
        assert measured < min(
            solved(problem, "gfmd", {"damping": c}, residual=1e-5, most=800).iterations
            for c in constants
        )


def test_no_faster_than_stable():
    """At the stability limit and with little damping, the fastest mode still dies out."""
    problem = problem_of(ROUGH["64"], 0.353)
    assert solved(problem, "gfmd", {"dt": 1.0}, residual=1e-6).iterations < 200


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("gfmd", {"mass": 1.0}, "dt, damping"),
        ("gfmd", {"dt": 1.5}, "0.01 to 1"),
        ("gfmd", {"damping": -1}, "0 to"),
        ("fire", {"damping": 1.0}, "'fire': dt"),
        ("ccg", {"dt": 1.0}, "preconditioned"),
        ("gfmd", {"dt": float("nan")}, "0.01 to 1"),
    ],
)
def test_options_are_checked(name, options, message):
    with pytest.raises(SceneError, match=message):
        solver_class(name)(problem_of(ROUGH["64"], 0.1), options)


# -- kernels, against the same in NumPy
# -----------------------------------------------------------------------------


@pytest.fixture
def fields():
    rng = np.random.default_rng(0)
    return [np.maximum(f, 0) if k == 0 else f for k, f in enumerate(rng.standard_normal((5, 6, 9)))]


def test_verlet_step(fields):
    g, p, d, x, _ = fields
    v = 0.7 * d - 0.3 * p
    wanted = np.maximum(g + v, 0)
    change, kept = np.where(g + v <= 0, -g, v), np.where(g + v <= 0, 0, v)
    verlet_step(g, p, d, x, 0, 6, 0.3, 0.7, g.shape)
    np.testing.assert_allclose(g, wanted, atol=1e-15)
    np.testing.assert_allclose(x, change, atol=1e-15)
    np.testing.assert_allclose(d, kept, atol=1e-15)


def test_update_pressure(fields):
    g, p, d, x, _ = fields
    fresh = p + x
    free = ~((g <= 0) & (fresh > 0))
    sums = update_pressure(g, p, d, x, 0, 6, g.shape)
    np.testing.assert_allclose(p, fresh)
    np.testing.assert_allclose(
        sums,
        [
            (fresh**2)[free].sum(),
            (fresh**2).sum(),
            (fresh * d).sum(),
            (d**2).sum(),
            (d * x).sum(),
            (~free).sum(),
            g.sum(),
        ],
    )


def test_pressure_passes(fields):
    p, gap0, t, x, h = fields
    g = np.where(gap0 > 0, 0, p)
    wanted = np.where(g <= 0, np.maximum(0.2 + x, 0), 0)
    found = np.empty_like(p)
    assert ccg.start_pressure(g, found, x, 0.2, g.shape, 0, 6) == pytest.approx(wanted.sum())
    np.testing.assert_allclose(found, wanted)

    touching, e = p > 0, gap0 - 0.1
    wanted = np.where(touching, 2 * e + 0.5 * t - 0.3, 0)
    sums = ccg.search_direction(t, gap0, p, x, 0, 6, 0.1, 2.0, 0.5, 0.3)
    np.testing.assert_allclose(t, wanted)
    np.testing.assert_allclose(x, wanted)
    np.testing.assert_allclose(sums, [(e * wanted).sum(), wanted.sum()])

    wanted = np.maximum(np.where(touching, p - 0.4 * t, -0.6 * e), 0)
    sums = ccg.pressure_step(p, t, gap0, x, 0, 6, 0.1, 0.4, 0.6, p.shape)
    np.testing.assert_allclose(p, wanted)
    np.testing.assert_allclose(sums, [wanted.sum(), (~touching & (wanted > 0)).sum()])

    wanted = 3 * x + h - 0.5
    sums = ccg.new_gap(p, gap0, h, x, 0, 6, 3.0, 0.5)
    np.testing.assert_allclose(gap0, wanted)
    np.testing.assert_allclose(sums, [wanted[p > 0].sum(), (p > 0).sum()])

    e, p_out = gap0 - 0.2, np.empty_like(p)
    gap = np.where(p > 0, 0, np.maximum(e, 0))
    sums = ccg.feasible_state(p, gap0, g, p_out, 0.2, g.shape)
    np.testing.assert_allclose(g, gap)
    np.testing.assert_allclose(p_out, p)
    np.testing.assert_allclose(
        sums, [(e[p > 0] ** 2).sum(), (e[(p <= 0) & (e < 0)] ** 2).sum(), (p > 0).sum(), gap.sum()]
    )
