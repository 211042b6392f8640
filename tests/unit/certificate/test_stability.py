"""The stability of an equilibrium against the smallest eigenvalue of dense matrices."""

from dataclasses import replace

import numpy as np
import oracle
import pytest
from scipy.linalg import eigh

from hpc_gfmd.certificate.certificate import certify
from hpc_gfmd.certificate.stability import stability_of, stability_up_to_equilibrium
from hpc_gfmd.laws import law_named
from hpc_gfmd.operators.problem import Problem
from hpc_gfmd.parallel.grid import Grid
from hpc_gfmd.solvers.bpx import Bpx

N = 24
P0 = 0.05


def wall(work, reach, name="exponential", dtype=np.float64):
    """The Problem of a smooth random wall with attraction; heights of order one grid spacing."""
    z = np.fft.fft2(np.random.default_rng(1).standard_normal((N, N)))
    q = np.hypot(*np.meshgrid(np.fft.fftfreq(N), np.fft.fftfreq(N), indexing="ij"))
    z = np.fft.ifft2(z * np.exp(-((8 * q) ** 2))).real
    h = ((z.max() - z) / z.std()).astype(dtype)
    return Problem(Grid((N, N), (1.0, 1.0)), h, P0, attraction=law_named(name, work, reach))


def begun(problem):
    solver = Bpx(problem)
    solver.start(np.maximum(problem.heights - 1.5, 0).astype(problem.dtype))
    return solver


def solved(problem):
    """A solver at equilibrium."""
    solver = begun(problem)
    for _ in range(500):
        solver.step()
        if solver.progress().residual < (1e-12 if problem.dtype == np.float64 else 1e-4):
            break
    return solver


def stability(solver, **options):
    return stability_of(solver.problem, solver.state.g, solver.state.p, solver.levels, **options)


def dense(solver):
    """(open points, K and the curvature of the energy there, smallest eigenvalue)."""
    is_open = ~((solver.state.g <= 0) & (solver.state.p > 0)).ravel()
    K = oracle.stiffness(solver.grid.n, (N, N))[np.ix_(is_open, is_open)]
    curvature = solver.problem.attraction.curvature(solver.state.g).ravel()[is_open]
    return is_open, K, curvature, 1 + eigh(np.diag(curvature), K, eigvals_only=True)[0]


@pytest.mark.parametrize("name", ["exponential", "cubic", "dugdale"])
@pytest.mark.parametrize("work", [0.003, 0.02])
def test_stability_is_the_smallest_eigenvalue(name, work):
    solver = solved(wall(work, 0.4, name))
    is_open, K, curvature, exact = dense(solver)
    result = stability(solver, tolerance=1e-7)
    assert result.value == pytest.approx(exact, abs=2e-5)
    assert result.lowest <= result.value
    assert result.mode is not None
    e = result.mode.ravel()[is_open]
    assert (e @ (K @ e + curvature * e)) / (e @ K @ e) == pytest.approx(exact, abs=1e-4)
    assert result.mode.sum() > 0


@pytest.mark.parametrize("enough", [0.05, 0.3, 0.6, 2.0])
def test_early_stops_give_bounds(enough):
    solver = solved(wall(0.05, 0.4))
    *_, exact = dense(solver)
    result = stability(solver, enough=enough)
    assert result.lowest <= exact + 1e-6
    assert result.value >= exact - 1e-6


def test_stability_in_single_precision():
    double, single = (solved(wall(0.05, 0.4, dtype=dtype)) for dtype in (np.float64, np.float32))
    assert stability(single).value == pytest.approx(stability(double).value, abs=0.05)


def test_stability_out_of_range_is_one():
    result = stability(solved(wall(1e-3, 1e-3, "cubic")))
    assert result.value == pytest.approx(1, abs=0.2)
    assert result.value <= 1


def test_duality_gap_bounds_the_distance_to_the_equilibrium():
    """The duality gap bounds the distance to the contact with fixed attraction; divided by the
    stability, it bounds the distance to the equilibrium to first order."""
    problem = wall(0.05, 0.4)
    exact = solved(problem)
    rough = begun(problem)
    K = oracle.stiffness(problem.grid.n, (N, N))
    for _ in range(200):
        rough.step()
        e = (rough.state.g - exact.state.g).ravel()
        distance = np.sqrt(e @ K @ e)
        if distance < 1e-3 * np.sqrt(exact.state.uKu):
            break
    certificate = certify(problem, rough.state, rough.levels, dual=True)
    wall_load = problem.p0 + certificate.attraction
    bound = np.sqrt(2 * certificate.duality_gap * wall_load * certificate.gap_mean * N * N)
    *_, s = dense(exact)
    assert 1e-12 < distance <= 1.02 * bound / s


def settled(solver, p0):
    """Whether a solver reaches an equilibrium at a load; otherwise the bodies separate."""
    solver.continue_at(p0)
    for _ in range(3000):
        solver.step()
        if solver.is_separated or solver.progress().residual < 1e-11:
            break
    return not solver.is_separated


def test_lost_equilibria_are_not_certified():
    """Just beyond the load at which the contact is lost, a former equilibrium has a small residual
    and positive stability, although there is no equilibrium nearby."""
    problem = wall(0.05, 0.4)
    held = 0.01
    lost = -0.1
    solver = solved(replace(problem, p0=held))
    held_gap = solver.state.g.copy()
    while held - lost > 1e-6:
        middle = (held + lost) / 2
        solver.start(held_gap.copy())
        if settled(solver, middle):
            held = middle
            held_gap = solver.state.g.copy()
        else:
            lost = middle
    solver.state.p0 = held
    solver.start(held_gap.copy())
    assert settled(solver, held + 1e-4)
    before = solver.state.g.copy()
    K = oracle.stiffness(solver.grid.n, (N, N))
    certain = 0
    for change in 1e-4 * np.array([1e-3, 1e-2, 0.1, 0.3, 0.9, 1.1, 1.5, 3.0]):
        solver.start(before.copy())
        solver.continue_at(held + 1e-4 - change)
        distance = solver.progress().estimate.distance
        result = stability_of(solver.problem_now, solver.state.g, solver.state.p, solver.levels)
        assert result.value > 0
        s = stability_up_to_equilibrium(solver.problem_now, solver.state.g, result, distance)
        solver.after_stability()
        is_settled = settled(solver, held + 1e-4 - change)
        if s > 0:
            certain += 1
            e = (solver.state.g - before).ravel()
            assert is_settled
            assert np.sqrt(e @ K @ e) <= distance / s
    assert 2 <= certain <= 5
