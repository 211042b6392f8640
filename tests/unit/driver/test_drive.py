"""The loop over iterations with scripted solvers and certificates: when it asks for a certificate,
and the status of a load."""

from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
import pytest

from hpc_gfmd.certificate.certificate import Certificate
from hpc_gfmd.certificate.criterion import StoppingCriterion
from hpc_gfmd.certificate.error_estimates import Estimate
from hpc_gfmd.driver.certifier import Certifier
from hpc_gfmd.driver.drive import REFUSALS, drive
from hpc_gfmd.driver.target import Target
from hpc_gfmd.operators.state import State
from hpc_gfmd.solvers.base import Progress

ACCURACY = 1e-3
PAIRS = 1.0  # FFT pairs of a certificate


@dataclass
class Scripted:
    """A solver whose estimated error is a function of its iterations."""

    error: object
    patience: int = 60
    iterations: int = 0
    N: int = 100
    is_separated: bool = False
    goes_ahead: bool = False
    ahead: int = 0
    problem = SimpleNamespace(attraction=None)
    state: State = field(default_factory=lambda: State(None, None, None, p0=0.1))
    certified_at: list = field(default_factory=list)

    def progress(self):
        e = self.error(self.iterations)
        estimate = None if e is None else Estimate(0.1 * e, e, squares=0.0)
        return Progress(0.0, 10, 1.0, estimate, True)

    def step(self):
        self.iterations += 1

    def step_ahead(self):
        self.step()
        self.ahead += 1

    def expected_area(self, estimate):
        return 0.0

    def after_certificate(self):
        self.certified_at.append(self.iterations)


@pytest.fixture
def certified(monkeypatch):
    """certified(error) makes certificates with the error error(solver)."""

    def script(error):
        def certify(certifier, solver):
            e = error(solver)
            return Certificate(errors=(0.0, 0.1 * e, e), contact=10, gap_mean=1.0, pairs=PAIRS)

        monkeypatch.setattr(Certifier, "certify", certify)

    return script


def halving(iterations):
    return 0.5**iterations


CRITERION = StoppingCriterion(accuracy=ACCURACY, max_iterations=200)


def test_refusals_lower_the_threshold(certified):
    """Estimates that are 8 times too small cost one more certificate."""
    certified(lambda solver: 8 * halving(solver.iterations))
    solver = Scripted(halving)
    outcome = drive(solver, CRITERION)
    assert (outcome.status, outcome.pairs) == ("converged", 2 * PAIRS)
    (refused_at,) = solver.certified_at
    assert solver.iterations == refused_at + 3  # halvings


@pytest.mark.parametrize(("factor", "ahead", "pairs"), [(1, 1, 1), (1.5, 2, 2), (8, 1, 3)])
def test_the_last_step_and_its_certificate_are_made_together(certified, factor, ahead, pairs):
    """If its certificate is refused for a small error, the next step and certificate are, too; else
    the next certificate comes after a whole step."""
    certified(lambda solver: factor * halving(solver.iterations))
    solver = Scripted(halving, goes_ahead=True)
    outcome = drive(solver, CRITERION)
    assert (outcome.status, solver.ahead) == ("converged", ahead)
    assert outcome.pairs == pairs * PAIRS
    assert max(outcome.certificate.errors) < ACCURACY


def test_constant_certificates_are_stagnation(certified):
    certified(lambda solver: 2 * ACCURACY)
    outcome = drive(Scripted(halving), CRITERION)
    assert outcome.status == "stagnated"
    assert outcome.pairs <= PAIRS * (REFUSALS + 2)


def test_constant_estimates_are_stagnation(certified):
    certified(lambda solver: 1.0)
    solver = Scripted(lambda k: max(halving(k), 10 * ACCURACY), patience=20)
    outcome = drive(solver, CRITERION)
    assert (outcome.status, outcome.pairs) == ("stagnated", PAIRS)
    assert 20 < solver.iterations < 40


def test_unattainable_accuracy_stops_at_once(certified, monkeypatch):
    """Errors that the working precision does not allow to reduce are stagnation."""

    def certify(certifier, solver):
        errors = (0.0, 0.0, 5 * ACCURACY)
        return Certificate(errors=errors, attainable=(0.0, 5 * ACCURACY), contact=10, gap_mean=1.0)

    monkeypatch.setattr(Certifier, "certify", certify)
    assert drive(Scripted(halving), CRITERION).status == "stagnated"


@pytest.mark.parametrize(("meets", "status"), [(False, "max_iterations"), (True, "converged")])
def test_max_iterations(certified, meets, status):
    """A final certificate may accept a solution whose estimate was too large."""
    certified(lambda solver: 0.1 * ACCURACY if meets else 1.0)
    solver = Scripted(lambda k: 1.0, patience=1000)
    outcome = drive(solver, CRITERION)
    assert (outcome.status, solver.iterations) == (status, CRITERION.max_iterations)


class Doubling(Target):
    """A target that doubles the load after a number of certificates."""

    def __init__(self, times):
        super().__init__(0.1)
        self.times = times

    def judge(self, solver, certificate):
        return 2.0 if self.times else 0.0

    def correct(self, solver, certificate, solved):
        if not (self.times and solved):
            return False
        self.times -= 1
        solver.state.p0 *= 2
        return True


def test_targets_follow_certificates(certified):
    """Refusals are counted per load."""
    times = REFUSALS + 3
    certified(lambda solver: 0.1 * ACCURACY)
    solver = Scripted(halving)
    outcome = drive(solver, CRITERION, target=Doubling(times))
    assert outcome.status == "converged"
    assert solver.state.p0 == pytest.approx(0.1 * 2**times)
    assert outcome.pairs == PAIRS * (times + 1)


@pytest.mark.parametrize(("error", "status"), [(0.1, "converged"), (10, "stagnated")])
def test_a_target_goes_on_where_iterations_help_no_more(certified, error, status):
    """If the solution is accurate and the target alone is missed."""
    certified(lambda solver: error * ACCURACY)
    solver = Scripted(lambda k: 10 * ACCURACY, patience=5)
    outcome = drive(solver, CRITERION, target=Doubling(3))
    assert outcome.status == status
    assert solver.state.p0 == pytest.approx(0.8 if status == "converged" else 0.1)


@pytest.mark.parametrize(
    ("criterion", "certificate", "left"),
    [
        ({"accuracy": 1 / 999}, {"errors": (1e-4, 2e-3, 5e-4)}, 2.0),
        ({"accuracy": 1 / 999}, {"errors": (4e-3, 2e-3, 5e-4)}, 4.0),
        ({"accuracy": 1 / 999}, {"errors": (0.0, 2e-3, 5e-3), "attainable": (3e-3, 0.0)}, 5.0),
        ({"accuracy": 1 / 999}, {"errors": (0.0, 2e-3, 5e-3), "attainable": (0.0, 8e-3)}, 2.0),
        ({"residual": 1e-2}, {"errors": (0.0, 2.0, 2.0), "residual": 3e-2}, 3.0),
        ({"accuracy": 1 / 999}, {"errors": (0.0, 0.0, 0.0), "stability": 0.0}, np.inf),
        ({"accuracy": 1 / 999}, {"errors": (0.0, 0.0, 0.0), "stability": -0.1}, np.inf),
        ({"accuracy": 1 / 999}, {"errors": (0.0, 0.0, 0.0), "stability": 0.1}, 0.0),
        ({"residual": 1e-2}, {"residual": np.nan}, np.inf),
        ({"accuracy": 1 / 999}, {"errors": (np.nan, 0.0, 0.0)}, np.inf),
        ({"accuracy": 1 / 999}, {"errors": (0.0, np.nan, 0.0)}, np.inf),
        ({"accuracy": 1 / 999}, {"errors": (0.0, 0.0, np.nan)}, np.inf),
        ({"accuracy": 1 / 999}, {"errors": (0.0, 0.0, 2e-3), "attainable": (0.0, np.nan)}, 2.0),
    ],
)
def test_error_that_is_left(criterion, certificate, left):
    """States that are unstable or not finite never meet a criterion; errors of the working
    precision do not count. An error of 1e-3 of the value found is one of 1 / 999 of the true
    one."""
    made = Certificate(**{"contact": 10, "gap_mean": 1.0} | certificate)
    assert StoppingCriterion(**criterion).left(made) == pytest.approx(left)
