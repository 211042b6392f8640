"""The search for a mean gap or an approach that a spring holds."""

from types import SimpleNamespace

import numpy as np
import pytest

from hpc_gfmd.certificate.criterion import StoppingCriterion
from hpc_gfmd.certificate.stability import Stability
from hpc_gfmd.driver.branches import SaddleGuard
from hpc_gfmd.driver.drive import drive
from hpc_gfmd.driver.held import MOST_TRIALS, STIFFER, Held
from hpc_gfmd.laws import law_named
from hpc_gfmd.operators.problem import Problem
from hpc_gfmd.parallel.grid import Grid
from hpc_gfmd.solvers.bpx import Bpx

N = 16


def problem_of(p0=0.05, spring=0.0):
    """A wave with a weak attraction."""
    x = 2 * np.pi * np.arange(N) / N
    h = 2 - np.cos(x)[:, None] - np.cos(2 * x)
    grid = Grid((N, N), (1.0, 1.0))
    law = law_named("exponential", 0.01, 0.5)
    return Problem(grid, h - h.min(), p0, attraction=law, spring=spring)


def solver_of(problem):
    solver = Bpx(problem)
    solver.start(problem.heights.copy())
    return solver


def test_a_second_attempt_begins_as_the_first_did():
    """Pressure, spring, trials and note are those of the start again, for the same gap."""
    problem = problem_of()
    gap = problem.heights.copy()
    search = Held("gap_mean", 0.5, 1e-3, 0.05, problem, gap.mean(), gap)
    solver = solver_of(problem_of(spring=search.spring))
    while search.bring_back(solver):
        pass
    assert search.note is not None
    assert solver.state.p0 != 0.05
    assert search.begin() == search.p0 == 0.05
    assert search.note is None
    assert [search.bring_back(solver) for _ in range(MOST_TRIALS + 1)] == [True] * MOST_TRIALS + [
        False
    ]


def test_a_jump_begins_again_with_a_stiffer_spring():
    """At the gap of the start, which the spring holds by the pressure of the start."""
    problem = problem_of()
    gap = problem.heights + 0.25
    search = Held("gap_mean", gap.mean(), 1e-3, 0.05, problem, 2 * gap.mean(), gap)
    solver = solver_of(problem_of(spring=search.spring))
    search._before = (0.0, -1.0)
    assert search.bring_back(solver)
    assert solver.problem.spring == STIFFER * search.spring
    assert solver.state.p0 == pytest.approx(0.05)
    assert np.array_equal(solver.state.g, gap)


def test_a_gap_is_met_if_the_tolerance_holds_its_certified_error_too():
    """And once the slope is known, of which the error of its pressure is made."""
    problem = problem_of()
    search = Held("gap_mean", 0.5, 1e-3, 0.05, problem, 1.0, problem.heights)
    solver = solver_of(problem)
    first = SimpleNamespace(gap_mean=0.5 * (1 + 5e-4), errors=(0.0, 3e-4, 0.0))
    assert search.judge(solver, first) == 1
    assert search.correct(solver, first, solved=True)
    for error, is_met in ((3e-4, True), (5e-4, False)):
        certificate = SimpleNamespace(gap_mean=0.5 * (1 + 6e-4), errors=(0.0, error, 0.0))
        assert (search.judge(solver, certificate) < 1) == is_met


def test_the_stability_of_another_load_divides_no_estimate():
    solver = solver_of(problem_of())
    fresh = solver.progress().estimate.pressure
    solver.state.stability = Stability(0.01, 0.01, None, 0.0)
    assert solver.progress().estimate.pressure > 10 * fresh
    seen = []
    criterion = StoppingCriterion(accuracy=1e-3, max_iterations=5)
    watch = lambda _, progress: seen.append(progress.estimate.pressure)  # noqa: E731
    drive(solver, criterion, watch, guard=SaddleGuard(solver, "approach"))
    assert seen[0] == pytest.approx(fresh)
