"""What every solver promises. A new file in hpc_gfmd/solvers is tested by being there."""

import json
from dataclasses import replace

import numpy as np
import pytest
from contacts import (
    EXACT,
    field,
    problem_of,
    random_heights,
    relative,
    rough,
    solve_scene,
    surface_over,
)

from hpc_gfmd.certificate.certificate import certify
from hpc_gfmd.certificate.criterion import Target
from hpc_gfmd.driver.drive import drive
from hpc_gfmd.driver.nested import cold_gap
from hpc_gfmd.operators.problem import Problem
from hpc_gfmd.solvers import solver_class, solver_names
from hpc_gfmd.util.errors import SceneError

SURFACE = rough((2, 8, 3), seed=2)
every_solver = pytest.mark.parametrize("name", solver_names())


def started(name, problem):
    solver = solver_class(name)(problem, {})
    solver.start(cold_gap(problem))
    return solver


@every_solver
@pytest.mark.parametrize("p_star", [0.01, 0.1, 0.45])
def test_same_certified_solution(name, p_star):
    wanted = solve_scene(SURFACE, p_star, **EXACT)
    found = solve_scene(SURFACE, p_star, **EXACT | {"name": name, "residual": 1e-9})
    assert found.status == "converged"
    assert found.certificate.residual < 1e-9
    assert found.gap_mean == pytest.approx(wanted.gap_mean, rel=1e-6)
    assert found.contact_points == wanted.contact_points
    assert relative(field(found, "pressure"), field(wanted, "pressure")) < 1e-6
    # and by another way than the program's own certificate
    g, p = field(found, "gap"), field(found, "pressure")
    assert g.min() >= 0
    assert p.min() >= 0
    assert not (g * p).any()
    assert p.mean() == pytest.approx(found.p_mean, rel=1e-7)


@every_solver
def test_accuracy(name):
    wanted = solve_scene(SURFACE, 0.1, **EXACT)
    found = solve_scene(SURFACE, 0.1, name=name, accuracy=1e-2)
    assert found.status == "converged"
    assert found.gap_mean == pytest.approx(wanted.gap_mean, rel=1e-2)
    assert relative(field(found, "pressure"), field(wanted, "pressure")) < 1e-2
    assert abs(found.contact_points / wanted.contact_points - 1) <= 1e-2
    single = solve_scene(SURFACE, 0.1, name=name, residual=1e-3, precision="single")
    assert single.g.dtype == np.float32
    assert single.status == "converged"
    assert single.gap_mean == pytest.approx(wanted.gap_mean, rel=1e-2)


@every_solver
@pytest.mark.parametrize("hardness", [None, 0.3])
def test_state_goes_on_bit_by_bit(name, hardness):
    """state -> load_state of a new solver continues with exactly the numbers of the one that was
    never stopped."""
    problem = replace(problem_of(SURFACE), hardness=hardness if solver_class(name).dents else None)
    one = started(name, problem)
    for _ in range(7):
        one.step()
    arrays, numbers = one.state()
    arrays = {k: np.array(v) for k, v in arrays.items()}
    numbers = json.loads(json.dumps(numbers))  # as a checkpoint keeps them
    other = solver_class(name)(problem, {})
    other.load_state(arrays, numbers)
    for _ in range(9):
        one.step()
        other.step()
        assert np.array_equal(one.g, other.g)
        assert np.array_equal(one.p, other.p)
        assert one.progress() == other.progress()
    assert one.iterations == other.iterations == 16


@every_solver
def test_progress_and_pairs(name):
    """Progress tells what the state is; an iteration costs at least one FFT pair, and all are
    counted."""
    solver = started(name, problem_of(SURFACE))
    for _ in range(20):
        before = solver.pairs
        solver.step()
        assert solver.pairs >= before + 1
    progress = solver.progress()
    closed = (solver.g <= 0) & (solver.p > 0)
    assert progress.finite
    assert solver.iterations == 20
    assert progress.gap_mean == pytest.approx(solver.g.mean(), rel=1e-9)
    assert progress.contact == closed.sum()
    assert solver.g.min() >= 0
    if solver.p[~closed].any():  # a solver in pressures has none there
        rms = np.sqrt(np.sum(solver.p[~closed] ** 2) / solver.N) / solver.p0
        assert progress.residual == pytest.approx(rms, rel=0.5)


@every_solver
def test_the_pressure_is_that_of_the_gap(name):
    """After many steps p still is p0 + K (g - h)."""
    solver = started(name, problem_of(SURFACE))
    for _ in range(50):
        solver.step()
    kept, fresh = solver.p.copy(), np.empty_like(solver.p)
    certify(solver.problem_now, solver.g, fresh)
    assert np.abs(kept - fresh).max() < 1e-9 * np.abs(fresh).max()


@every_solver
def test_another_load(name):
    solver = started(name, problem_of(SURFACE))
    target = Target(residual=1e-8)
    assert drive(solver, target)[0] == "converged"
    solver.continue_at(0.12)
    assert solver.problem_now.p0 == 0.12
    status, certificate, _ = drive(solver, target)
    assert status == "converged"
    wanted = solve_scene(SURFACE, 0.12, **EXACT)
    height = wanted.surface.height_unit
    assert certificate.gap_mean * height == pytest.approx(wanted.gap_mean, rel=1e-6)


@every_solver
@pytest.mark.parametrize("n", [(1, 16), (16, 1), (5, 7), (2, 2), (3, 1), (32, 3)], ids=str)
def test_any_grid(name, n):
    z = random_heights(n, seed=11)
    made = surface_over(z)
    assert (
        drive(started(name, Problem(made.grid, made.h, 0.1)), Target(residual=1e-8))[0]
        == "converged"
    )


@every_solver
def test_stops(name):
    """At max_iterations, when told to, and with NaN: never as converged."""
    problem = problem_of(SURFACE)
    solver = started(name, problem)
    assert drive(solver, Target(residual=1e-13, max_iterations=3))[0] == "max_iterations"
    assert solver.iterations == 3
    assert (
        drive(solver, Target(residual=1e-13), lambda iterations, progress: iterations >= 5)[0]
        == "interrupted"
    )
    assert solver.iterations == 5
    broken = replace(problem, h=problem.h.copy())
    broken.h[3, 4] = np.nan
    solver = solver_class(name)(broken, {})
    solver.start(np.maximum(broken.h - 1, 0))
    assert drive(solver, Target(accuracy=1e-2, max_iterations=50))[0] == "nonfinite"


@every_solver
def test_beyond_the_precision_it_stagnates(name):
    step = solve_scene(
        SURFACE, 0.1, name=name, residual=1e-12, precision="single", max_iterations=3000
    )
    assert step.status in ("stagnated", "max_iterations")


@every_solver
def test_unknown_option(name):
    with pytest.raises(SceneError, match="bogus"):
        solver_class(name)(problem_of(SURFACE), {"bogus": 1.0})
