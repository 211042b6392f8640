"""The contract of solvers; new files in hpc_gfmd/solvers are tested automatically, here and on
grids of any shape in tests/physics/test_oracle.py."""

from dataclasses import replace

import numpy as np
import pytest
from contacts import EXACT, field, relative, rough, solve_scene, started_cold, sweep_of

from hpc_gfmd.certificate.certificate import certify
from hpc_gfmd.certificate.criterion import StoppingCriterion
from hpc_gfmd.driver.drive import drive
from hpc_gfmd.operators.problem import Problem
from hpc_gfmd.solvers import solver_class, solver_names
from hpc_gfmd.util.errors import SceneError

SURFACE = rough((2, 8, 3), seed=2)
every_solver = pytest.mark.parametrize("name", solver_names())
KINDS = [*[(name, {}) for name in solver_names()], ("gfmd", {"damping": 1.0})]


def problem_of(p0=0.1):
    made = sweep_of(SURFACE).surface
    return Problem(made.grid, made.h, p0)


@pytest.mark.parametrize(("name", "options"), KINDS)
@pytest.mark.parametrize(
    ("surface", "p_star"),
    [
        *[(SURFACE, p_star) for p_star in (1e-3, 0.01, 0.1, 0.45, 1.0)],
        *[(rough((2, 16, 4), hurst=0.3, seed=4), p_star) for p_star in (0.007, 0.353)],
    ],
)
def test_same_certified_solution(name, options, surface, p_star):
    """Without nested starts, in which another solver works on coarse grids."""
    wanted = solve_scene(surface, p_star, **EXACT)
    settings = {"name": name, "options": options, "residual": 1e-9, "nested": False}
    solved = solve_scene(surface, p_star, **EXACT | settings)
    assert solved.status == "converged"
    assert solved.certificate.residual < 1e-9
    assert solved.gap_mean == pytest.approx(wanted.gap_mean, rel=1e-6)
    # conditions of the solution, checked without the certificate
    g = field(solved, "gap")
    p = field(solved, "pressure")
    assert relative(p, field(wanted, "pressure")) < 1e-6
    assert np.array_equal(p > 0, field(wanted, "pressure") > 0)
    assert g.min() >= 0
    assert p.min() >= 0
    assert not (g * p).any()
    assert p.mean() == pytest.approx(solved.p_mean, rel=1e-7)


@every_solver
@pytest.mark.parametrize("accuracy", [1e-2, 1e-5])
def test_accuracy(name, accuracy):
    wanted = solve_scene(SURFACE, 0.1, **EXACT)
    solved = solve_scene(SURFACE, 0.1, name=name, accuracy=accuracy)
    assert solved.status == "converged"
    assert max(solved.certificate.errors) < accuracy
    assert solved.gap_mean == pytest.approx(wanted.gap_mean, rel=accuracy)
    assert relative(field(solved, "pressure"), field(wanted, "pressure")) < accuracy
    assert abs(solved.contact_points / wanted.contact_points - 1) <= accuracy


@every_solver
def test_single_precision(name):
    """Solvers converge as far as single precision allows, and stagnate beyond."""
    wanted = solve_scene(SURFACE, 0.1, **EXACT)
    single = solve_scene(SURFACE, 0.1, name=name, residual=1e-3, precision="single")
    assert single.g.dtype == np.float32
    assert single.status == "converged"
    assert single.gap_mean == pytest.approx(wanted.gap_mean, rel=1e-2)
    beyond = {"residual": 1e-12, "precision": "single", "max_iterations": 3000}
    step = solve_scene(SURFACE, 0.1, name=name, **beyond)
    assert step.status in ("stagnated", "max_iterations")


@every_solver
def test_progress_and_pairs(name):
    """Progress describes the state; an iteration costs one FFT pair, the first one exactly."""
    solver = started_cold(name, problem_of())
    pairs = [solver.pairs]
    for _ in range(20):
        solver.step()
        pairs.append(solver.pairs)
    assert pairs[1] - pairs[0] == 1 <= np.diff(pairs).min()
    progress = solver.progress()
    closed = (solver.state.g <= 0) & (solver.state.p > 0)
    assert progress.finite
    assert solver.iterations == 20
    assert progress.gap_mean == pytest.approx(solver.state.g.mean(), rel=1e-9)
    assert progress.contact == closed.sum()
    assert solver.state.g.min() >= 0
    if solver.state.p[~closed].any():  # a solver in pressures has none there
        rms = np.sqrt(np.sum(solver.state.p[~closed] ** 2) / solver.N) / solver.state.p0
        assert progress.residual == pytest.approx(rms, rel=0.5)


@every_solver
def test_pressure_follows_the_gap_over_many_steps(name):
    """After 50 steps p is still p0 + K (g - h)."""
    solver = started_cold(name, problem_of())
    for _ in range(50):
        solver.step()
    followed = solver.state.p.copy()
    certify(solver.problem_now, solver.state)
    fresh = solver.state.p
    assert np.abs(followed - fresh).max() < 1e-9 * np.abs(fresh).max()


@pytest.mark.parametrize("hardness", [np.inf, 0.6])
def test_a_step_ahead_leaves_the_pressure_to_a_certificate(hardness):
    """Where the line search does not shorten the step, both ways reach the same state."""
    problem = replace(problem_of(), hardness=hardness)
    ahead, whole = (started_cold("bpx", problem) for _ in range(2))
    compared = 0
    for _ in range(8):
        ahead.step_ahead()
        certificate = certify(problem, ahead.state, ahead.levels)
        whole.step()
        if whole.s == 1:
            assert np.array_equal(ahead.state.g, whole.state.g)
            assert relative(ahead.state.p, whole.state.p) < 1e-12
            assert certificate.uKu == pytest.approx(whole.state.uKu, rel=1e-12)
            compared += 1
        for solver in (ahead, whole):
            solver.start(whole.state.g)
            solver.step()
    assert compared > 2


@every_solver
def test_continuation_at_another_load(name):
    solver = started_cold(name, problem_of(0.1))
    target = StoppingCriterion(residual=1e-8)
    assert drive(solver, target)[0] == "converged"
    solver.continue_at(0.12)
    assert solver.problem_now.p0 == 0.12
    status, certificate, _ = drive(solver, target)
    assert status == "converged"
    wanted = solve_scene(SURFACE, 0.12, **EXACT)
    height = wanted.surface.height_unit
    assert certificate.gap_mean * height == pytest.approx(wanted.gap_mean, rel=1e-6)


@every_solver
def test_reasons_to_stop(name):
    """max_iterations, an interrupt and NaN; never converged."""
    problem = problem_of()
    solver = started_cold(name, problem)
    assert drive(solver, StoppingCriterion(residual=1e-13, max_iterations=3))[0] == "max_iterations"
    assert solver.iterations == 3
    assert (
        drive(
            solver, StoppingCriterion(residual=1e-13), lambda iterations, progress: iterations >= 5
        )[0]
        == "interrupted"
    )
    assert solver.iterations == 5
    broken = replace(problem, h=problem.h.copy())
    broken.h[3, 4] = np.nan
    solver = solver_class(name)(broken, {})
    solver.start(np.maximum(broken.h - 1, 0))
    assert drive(solver, StoppingCriterion(accuracy=1e-2, max_iterations=50))[0] == "nonfinite"


BAD_OPTIONS = [
    *[(name, {"bogus": 1.0}, "bogus") for name in solver_names()],
    ("gfmd", {"mass": 1.0}, "dt, damping"),
    ("gfmd", {"dt": 1.5}, "0.01 to 1"),
    ("gfmd", {"dt": float("nan")}, "0.01 to 1"),
    ("gfmd", {"damping": -1}, "0 to"),
]


def test_options_are_checked():
    for name, options, message in BAD_OPTIONS:
        with pytest.raises(SceneError, match=message):
            solver_class(name)(problem_of(), options)


def test_gfmd_converges_at_its_stability_limit():
    """With little damping, the fastest mode still decays."""
    solver = started_cold("gfmd", problem_of(0.353), {"dt": 1.0})
    assert drive(solver, StoppingCriterion(residual=1e-6, max_iterations=200))[0] == "converged"


def test_critical_damping_of_gfmd_is_the_fastest():
    """With less the longest wave oscillates, with more it creeps."""
    iterations = []
    for damping in (0.1, 1.0, 10.0):
        solver = started_cold("gfmd", problem_of(), {"damping": damping})
        assert drive(solver, StoppingCriterion(residual=1e-6))[0] == "converged"
        iterations.append(solver.iterations)
    assert iterations[1] < 0.7 * min(iterations[0], iterations[2])
