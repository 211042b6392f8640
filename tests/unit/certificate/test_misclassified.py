"""How many points may be on the wrong side of contact."""

import numpy as np
import pytest
from contacts import rough, sweep_of

from hpc_gfmd.certificate.error_estimates import Estimate
from hpc_gfmd.certificate.misclassified import misclassified_points


@pytest.fixture(scope="module")
def state():
    """(problem, gap, pressure, contact points) of a solved contact."""
    sweep = sweep_of(rough((1, 32, 2)), accuracy=1e-6)
    contact = sweep.solve(0.1 * sweep.surface.g_rms)
    solver = sweep.starter.solver
    return solver.problem_now, solver.state.g, solver.state.p, contact.contact_points


def test_nothing_changes_without_an_error(state):
    problem, g, p, n = state
    assert misclassified_points(problem, g, p, Estimate(squares=0.0), spread=10, contact=n) == 0


@pytest.mark.parametrize("share", [0.02, 0.1])
def test_points_follow_a_missing_load(state, share):
    """In proportion to it, out of contact where the contact carries too much."""
    problem, g, p, n = state
    squares = 1e-2 * float(np.sum(p[g <= 0].astype(float) ** 2))
    for sign in (1, -1):
        errors = Estimate(squares=squares, growth=sign * share * n)
        expected = share * n
        wrong = misclassified_points(problem, g, p, errors, spread=n, contact=n)
        assert wrong >= expected


def test_an_open_point_takes_no_more_than_it_is_pressed_down_by_itself(state):
    """A pressure taken over from n points, as large as the error, may close a gap of S00 (1 + 1/n)
    times it."""
    problem, _, p, _ = state
    grid = problem.grid
    g = np.ones_like(p)
    pressure = np.zeros_like(p)
    g[3, 4] = 0.0
    pressure[3, 4] = 1.0
    error = 0.01
    reach = error * problem.body.point_compliance(grid) * np.sqrt(2)
    for gap, may_change in ((0.9 * reach, True), (1.1 * reach, False)):
        g[9, 9] = gap
        errors = Estimate(squares=error**2)
        wrong = misclassified_points(problem, g, pressure, errors, spread=1, contact=1)
        assert (wrong > 0) == may_change
