"""The certificate decides about convergence, and its errors bound the true ones."""

from dataclasses import replace

import numpy as np
import oracle
import pytest
from contacts import random_heights, rough, started_cold, sweep_of

import hpc_gfmd
from hpc_gfmd.bodies.halfspace import HALF_SPACE
from hpc_gfmd.certificate.certificate import certify
from hpc_gfmd.certificate.criterion import StoppingCriterion
from hpc_gfmd.certificate.error_estimates import Estimate
from hpc_gfmd.driver.drive import drive
from hpc_gfmd.operators.multilevel import Multilevel
from hpc_gfmd.operators.problem import Problem
from hpc_gfmd.operators.state import State
from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.parallel.grid import Grid
from hpc_gfmd.solvers import solver_names
from hpc_gfmd.solvers.bpx import Bpx
from hpc_gfmd.surface.cell import grid_of

ROUNDING = 1e-12  # of reference solutions in double precision


@pytest.fixture
def surface():
    return sweep_of(rough(), precision="double").surface


def started(surface, p_star, name="bpx", hardness=np.inf):
    """A solver at its cold start."""
    return started_cold(name, Problem(surface.grid, surface.h, p_star, hardness=hardness))


def in_contact(g, p):
    """The pressure field as returned to users: 0 out of contact."""
    return np.where((g <= 0) & (p > 0), p, 0)


def certified(solver, **options):
    """(certificate, pressure) of a solver's state; the solver can continue."""
    state = replace(solver.state, p=np.empty_like(solver.state.p))
    certificate = certify(solver.problem_now, state, solver.levels, **options)
    if solver.progress().estimate is not None:
        solver.restart()
    return certificate, state.p


@pytest.mark.parametrize("wrong", [1e-9, 0.0])
def test_wrong_estimates_are_overruled(surface, monkeypatch, wrong):
    """A solver that estimates convergence from the start iterates until it has converged."""
    monkeypatch.setattr(Bpx, "_estimate", lambda self: Estimate(wrong, wrong, squares=wrong))
    monkeypatch.setattr(Bpx, "expected_area", lambda self, estimate: wrong)
    status, certificate, _ = drive(started(surface, 0.05), StoppingCriterion(accuracy=1e-4))
    _, exact, _ = drive(started(surface, 0.05), StoppingCriterion(residual=1e-12))
    assert status == "converged"
    assert max(certificate.errors) < 1e-4
    assert abs(certificate.gap_mean / exact.gap_mean - 1) <= certificate.errors[1] + ROUNDING
    assert abs(certificate.contact / exact.contact - 1) <= certificate.errors[0] + ROUNDING


@pytest.mark.parametrize("name", solver_names())
def test_errors_bound_true_errors_during_iteration(surface, name):
    """Checked for all states with errors below 0.1."""
    truth = started(surface, 0.05)
    _, exact, _ = drive(truth, StoppingCriterion(residual=1e-12))
    wanted = in_contact(truth.state.g, truth.state.p)
    norm = np.linalg.norm(truth.state.p)
    solver = started(surface, 0.05, name)
    compared = 0
    for _ in range(40 if name == "bpx" else 200):
        certificate, p = certified(solver)
        area, gap, pressure = certificate.errors
        if max(certificate.errors) < 0.1:
            compared += 1
            assert abs(certificate.contact / exact.contact - 1) <= area + ROUNDING
            assert abs(certificate.gap_mean / exact.gap_mean - 1) <= gap + ROUNDING
            wrong = np.linalg.norm(in_contact(solver.state.g, p) - wanted)
            assert wrong <= (pressure + ROUNDING) * norm
        solver.step()
    assert compared > 3


@pytest.mark.parametrize(
    ("p_star", "hardness"),
    [(1e-3, np.inf), (0.02, np.inf), (0.2, np.inf), (0.5, np.inf), (0.02, 0.5), (0.1, 0.3)],
)
def test_energy_bound_against_the_duality_gap(surface, p_star, hardness):
    """The error of the pressure agrees with the bound by the duality gap within 50 %."""
    solver = started(surface, p_star, hardness=hardness)
    compared = 0
    for _ in range(24):
        solver.step()
        certificate, p = certified(solver, dual=True)
        if not (certificate.duality_gap < np.inf and 1e-12 < certificate.errors[2] < 0.5):
            continue
        closed = np.sum(np.minimum(p, hardness)[(solver.state.g <= 0) & (p > 0)] ** 2)
        G = certificate.duality_gap * p_star * certificate.gap_mean * surface.grid.N
        # of the relative error of the pressure, up to a factor of order one
        bound = np.sqrt(2 * G / (solver.compliance * closed))
        assert 0.5 * bound < certificate.errors[2] < 1.5 * bound
        compared += 1
    assert compared


def lowered(rng, touching):
    return -rng.random(touching.shape)


def lowered_as_a_whole(rng, touching):
    return -np.ones(touching.shape)


def lowered_in_contact_and_moved_elsewhere(rng, touching):
    waves = np.cos(np.arange(touching.shape[0]))[:, None] + rng.standard_normal(touching.shape)
    return np.where(touching, -np.abs(waves), waves)


@pytest.mark.parametrize(
    "change", [lowered, lowered_as_a_whole, lowered_in_contact_and_moved_elsewhere]
)
@pytest.mark.parametrize("by", [1e-4, 1e-3, 1e-2])
def test_a_displacement_that_penetrates_is_certified_by_the_nearest_feasible_one(change, by):
    """Errors and duality gap bound the true ones whatever displacement a solver returns."""
    z = random_heights((16, 16))
    wanted = oracle.solve(z, 0.3)
    grid = Grid(z.shape)
    problem = Problem(grid, z.max() - z, 0.3 * grid.a)
    g = wanted.gap + by * np.std(z) * change(np.random.default_rng(3), wanted.pressure > 0)
    deepest = -g.min()
    p = np.empty_like(g)
    levels = Multilevel(grid, HALF_SPACE, np.float64, 8)
    certificate = certify(problem, State(grid, g, p, problem.p0), levels, dual=True)
    area, gap, pressure = certificate.errors
    found = in_contact(g, p) / grid.a
    assert g.min() == 0
    assert certificate.penetration == deepest > 0
    assert certificate.duality_gap > 0
    assert abs(certificate.gap_mean / wanted.gap_mean - 1) <= gap
    assert abs(certificate.contact / (wanted.a_r * z.size) - 1) <= area
    norm = np.linalg.norm(wanted.pressure)
    assert np.linalg.norm(found - wanted.pressure) <= pressure * norm


@pytest.mark.parametrize("factor", [1.1, 1.3])
def test_steps_that_are_too_long_are_no_excuse(surface, monkeypatch, factor):
    """A solver whose steps end below the surface gives solutions as accurate as asked."""
    truth = started(surface, 0.1)
    drive(truth, StoppingCriterion(residual=1e-12))
    wanted = in_contact(truth.state.g, truth.state.p)
    update = Bpx._update
    monkeypatch.setattr(Bpx, "_update", lambda self, s: update(self, factor * s))
    solver = started(surface, 0.1)
    status, certificate, _ = drive(solver, StoppingCriterion(accuracy=1e-3, max_iterations=100))
    assert status == "converged"
    wrong = np.linalg.norm(in_contact(solver.state.g, solver.state.p) - wanted)
    assert wrong / np.linalg.norm(wanted) <= certificate.errors[2] < 1e-3


def held_by_a_spring(z, solution, work, reach):
    """(p, gap) of the equilibrium at the same end of the spring (cubic law), by dense Newton."""
    # gap and p differ together along the line of the spring
    k = solution.p_error * abs(solution.p) / (solution.gap_error * solution.gap_mean)
    K = oracle.stiffness(z.shape, (1.0, 1.0), 1.0)
    g = np.asarray(solution.gap, float).ravel()
    free = np.asarray(solution.pressure).ravel() == 0
    offset = solution.p - k * g.mean() - K @ (z.max() - z).ravel()
    K = K + k / z.size  # the spring: a pressure by the mean gap
    for _ in range(30):
        closeness = np.maximum(1 - g / reach, 0)
        residual = offset + K @ g + 3 * work / reach * closeness**2
        softer = K - np.diag(6 * work / reach**2 * closeness)
        g[free] -= np.linalg.solve(softer[np.ix_(free, free)], residual[free])
    assert np.abs(residual[free]).max() < ROUNDING
    return solution.p + k * (g.mean() - np.mean(np.asarray(solution.gap, float))), g.mean()


@pytest.mark.parametrize("accuracy", [1e-2, 1e-3])
def test_errors_at_a_held_gap_are_those_of_what_the_spring_holds(accuracy):
    """On a wave whose contact has a gap 4 % larger at the returned p as a dead load."""
    n, work, reach = 19, 0.0082345, 0.15208
    z = 0.0288851 * np.cos(2 * np.pi * (np.arange(n) + 0.5) / n)[:, None] * np.ones(n)
    (solution,) = hpc_gfmd.solve(
        z,
        gap_mean=[0.01114874],
        E_star=1.0,
        adhesion={"work": work, "range": reach, "law": "cubic"},
        branch="retraction",
        accuracy=accuracy,
    )
    p, gap = held_by_a_spring(z, solution, work, reach)
    assert solution.status == "converged"
    assert abs(gap / solution.gap_mean - 1) <= solution.gap_error < accuracy
    assert abs(p / solution.p - 1) <= solution.p_error


@pytest.mark.parametrize("boundary", ["periodic", "free"])
def test_the_error_of_a_held_pressure_is_that_of_the_gap_times_the_spring(boundary):
    """The spring is 8 times as stiff as the longest wave of the cell, larger with free edges; what
    the gap misses counts with the slope of the pressure.
    """
    solution = hpc_gfmd.solve(
        random_heights((16, 16)) / 100,
        gap_mean=0.02,
        adhesion={"work": 1e-4, "range": 0.01, "law": "exponential"},
        boundary=boundary,
    )
    free = (boundary == "free",) * 2
    grid = grid_of((16, 16), (1.0, 1.0), SerialComm(), free)
    cells = grid.cell_points / grid.N
    spring = cells * 8 * np.pi / np.sqrt(cells)
    error = solution.gap_error * solution.gap_mean
    of_missed = solution.p_error * abs(solution.p) - spring * error
    assert 0 < of_missed < 2 * spring * (abs(solution.gap_mean - 0.02) + error)


def test_full_contact_under_tension_is_not_certified():
    """Tensile points in full contact make the error of the gap infinite."""
    z = random_heights((16, 16))
    grid = Grid(z.shape)
    problem = Problem(grid, z.max() - z, 1e-3 * np.std(z))
    levels = Multilevel(grid, HALF_SPACE, np.float64, 8)
    state = State(grid, np.zeros(z.shape), np.empty(z.shape), problem.p0)
    certificate = certify(problem, state, levels, dual=True)
    assert certificate.tension > 1
    assert certificate.duality_gap == np.inf
    assert certificate.errors[1] == np.inf


@pytest.mark.parametrize("name", solver_names())
def test_error_of_the_gap_near_full_contact(name):
    """The error of a small mean gap holds against dense linear algebra."""
    z = random_heights((12, 12))
    wanted = oracle.solve(z, 3.0)
    solution = hpc_gfmd.solve(z, 3.0, name=name, accuracy=1e-4, precision="double")
    assert solution.status == "converged"
    assert solution.a_r == wanted.a_r
    assert (
        abs(solution.gap_mean - wanted.gap_mean)
        <= (solution.errors[1] + ROUNDING) * wanted.gap_mean
    )


def test_many_points_with_equal_tiny_pressures():
    """576 points of a wave with a pressure of 1e-7 enter or leave contact together."""
    cos = np.cos(np.pi * np.arange(96) / 8)
    solution = hpc_gfmd.solve(np.outer(cos, cos), p_star=0.24489848, accuracy=1e-2)
    assert solution.status == "converged"
    assert round(solution.a_r * cos.size**2) == 4248
