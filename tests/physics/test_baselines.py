"""The paper's GFMD, FIRE and constrained conjugate gradients: their solutions, their options, and
what they cost."""

import numpy as np
import pytest
from contacts import problem_of, rough

from hpc_gfmd.certificate.certificate import certify
from hpc_gfmd.driver.nested import cold_gap
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
ROUGH = {"64": rough(seed=3), "128": rough((2, 16, 4), hurst=0.3, seed=4)}


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
    for p0 in (1e-4, 0.007, 0.05, 0.353, 1.0, 2.0):
        if p0 < 1e-3 and (kind == "gfmd-constant" or size == "128"):
            continue  # that damping is far too much; there, no point would touch
        problem = problem_of(ROUGH[size], p0)
        found, wanted = (
            solved(problem, *KINDS[kind]),
            solved(problem, "bpx", residual=1e-11, most=60),
        )
        certificate = assert_same(found, wanted, 1e-7)
        assert certificate.residual < 2e-9
        assert certificate.load_balance < 1e-8


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
        ("ccg", {"preconditioned": 0.5}, "a whole number from 0 to 1"),
        ("gfmd", {"dt": float("nan")}, "0.01 to 1"),
    ],
)
def test_options_are_checked(name, options, message):
    with pytest.raises(SceneError, match=message):
        solver_class(name)(problem_of(ROUGH["64"], 0.1), options)
