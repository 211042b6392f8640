"""The only loop: iterate a solver until its load is solved, its limits or a request to stop, and
certify what it returns."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..certificate.certificate import Certificate, certify
from ..certificate.criterion import StoppingCriterion
from .search import area_may_be_met

if TYPE_CHECKING:
    from ..solvers.base import Progress, Solver
    from .branches import SaddleGuard
    from .search import LoadSearch

    Watch = Callable[[int, Progress], Any]


@dataclass(frozen=True)
class LoopCalibration:
    """When a solver is certified, and when it counts as stagnated.

    What ends an iteration is the certificate: these numbers cost or save pairs only.

    Attributes
    ----------
    refusals : int
        Times that the certificate may refuse without having come nearer, before the solver counts
        as stagnated.
    patience_at_floor : float
        Share of its patience that a solver has after a refusal: only rounding errors are left.
    improvement : float
        Factor on a measure of the error that counts as progress.
    look_again, look_again_after : float, int
        Share of the measure at which the stability was found to be too small, and iterations
        since: when it is looked for again, whichever comes first.
    waits : int
        Every so many times that a state is a saddle it is left by force.
    avalanche : float
        Share of the contact by which it changes: that is progress with an attraction.
    patience_with_attraction : float
        Times its patience that a solver has with an attraction: on its way from a saddle the errors
        rise for a while.
    """

    refusals: int = 5
    patience_at_floor: float = 1 / 6
    improvement: float = 0.9
    look_again: float = 0.3
    look_again_after: int = 10
    waits: int = 3
    avalanche: float = 0.01
    patience_with_attraction: float = 2.5


CALIBRATION = LoopCalibration()


class Outcome(NamedTuple):
    """What the iterations of a load have come to.

    Attributes
    ----------
    status : str
        See `contact.Contact`.
    certificate : Certificate
        Of the solver's gap; solver.p is its pressure, in the solver's precision.
    pairs : float
        FFT pairs that certificates took.
    """

    status: str
    certificate: Certificate
    pairs: float


def drive(
    solver: Solver,
    criterion: StoppingCriterion,
    watch: Watch | None = None,
    search: LoadSearch | None = None,
    guard: SaddleGuard | None = None,
) -> Outcome:
    """Iterate a solver that has been started.

    Collective.

    Parameters
    ----------
    solver : Solver
        At its start.
    criterion : StoppingCriterion
        What the solution has to reach.
    watch : callable, optional
        Called after every step, ``watch(iterations, progress)``; a true value stops.
    search : LoadSearch, optional
        Finds the mean pressure meanwhile, where it is not given.
    guard : SaddleGuard, optional
        Finds the stability, and leads away from saddles, where there is an attraction.

    Returns
    -------
    Outcome
        How the load has ended.
    """
    limits = Limits(solver, criterion)
    pairs = 0.0
    while True:
        if solver.is_separated:
            return Outcome("separated", Certificate(errors=(0.0, 0.0, 0.0)), pairs)
        progress = solver.progress()
        if search is not None and search.adjust(solver, progress):
            limits.begin_again()
            progress = solver.progress()
        limits.note(progress)
        may_be_solved = limits.ask_for_certificate(progress) and _may_be_met(
            solver, progress, criterion, search
        )
        if not may_be_solved:
            reason = limits.exceeded(progress)
            if reason is None and watch is not None and watch(solver.iterations, progress):
                reason = "interrupted"
            if reason is not None:
                outcome = _conclude(solver, criterion, search, guard, reason, pairs)
                if reason != "stagnated" or not _goes_elsewhere(solver, criterion, search, outcome):
                    return outcome
                pairs = outcome.pairs
                limits.begin_again()
            solver.step()
            continue
        if guard is not None:
            pairs += guard.look(limits.measure if criterion.residual is None else 0.0)
            if _leaves_saddle(limits, guard):
                continue
            if guard.at_saddle or not limits.is_stable_enough(solver.progress()):
                solver.stability = None
                solver.step()
                continue
        certificate = certificate_of(solver, criterion)
        pairs += certificate.pairs
        error = error_left(certificate, criterion)
        miss = search.learn(solver, certificate) if search is not None else 0.0
        if max(error, miss) < 1:
            return Outcome(_status_of(certificate, criterion), certificate, pairs)
        limits.note_refusal(certificate, max(error, miss))
        if limits.refused_too_often:
            return Outcome("stagnated", certificate, pairs)
        solver.stability = None
        solver.after_certificate(certificate)
        if search is not None and search.correct(solver, certificate, error < 1):
            limits.begin_again()
        solver.step()


def _goes_elsewhere(
    solver: Solver, criterion: StoppingCriterion, search: LoadSearch | None, outcome: Outcome
) -> bool:
    """Return whether a search goes on at another load, where the solution at this one is as
    accurate as asked. Collective."""
    certificate = outcome.certificate
    is_solved = (
        error_left(certificate, criterion) < 1 and _status_of(certificate, criterion) == "converged"
    )
    if search is None or outcome.status != "stagnated" or not is_solved:
        return False
    return search.correct(solver, certificate, is_solved)


def _leaves_saddle(limits: Limits, guard: SaddleGuard) -> bool:
    """Return whether the guard has led the solver away from a saddle, at which it has been for long
    enough. Collective."""
    if not guard.at_saddle or limits.wait_at_saddle() or not guard.leave_saddle():
        return False
    limits.begin_again()
    return True


class Limits:
    """Decides when the certificate is asked, and when a solver has had enough iterations.

    The solver's own measure of the error is compared with a threshold. Where the certificate
    refuses, the threshold is lowered by as much as the certificate misses.

    Parameters
    ----------
    solver : Solver
        What iterates.
    criterion : StoppingCriterion
        What the solution has to reach.
    """

    def __init__(self, solver: Solver, criterion: StoppingCriterion):
        self.solver = solver
        self.criterion = criterion
        self.begin_again()

    def begin_again(self) -> None:
        """Forget what was reached so far: the load has changed."""
        self.refusals = 0
        self.saddles = 0
        self.least_refused = np.inf  # the smallest error that the certificate refused
        self.threshold = 1.0  # of the measure, with the stability in it, for a certificate
        self.look_below = np.inf  # of the measure without it, for a look at the stability
        self.look_at = 0  # iterations from which on there is one anyway
        self.best = np.inf
        self.contact = 0.0
        self.best_at = self.solver.iterations

    def note(self, progress: Progress) -> None:
        """Note the progress of an iteration."""
        self.measure = self.asked = measure_of(progress, self.criterion)
        if self.measure < CALIBRATION.improvement * self.best:
            self.best = self.measure
            self.best_at = self.solver.iterations
        if self.solver.problem.attraction is not None:
            self._note_contact(progress.contact)

    def _note_contact(self, contact: float) -> None:
        """Note progress where the contact still changes: with an attraction it may close or open as
        an avalanche, while errors rise."""
        if abs(contact - self.contact) > max(CALIBRATION.avalanche * self.contact, 1):
            self.contact = contact
            self.best_at = self.solver.iterations

    def ask_for_certificate(self, progress: Progress) -> bool:
        """Return whether the solver believes that it is there."""
        is_time = self.measure < self.look_below or self.solver.iterations >= self.look_at
        return progress.finite and self.measure < self.threshold and is_time

    def note_refusal(self, certificate: Certificate, left: float) -> None:
        """Note a certificate that refuses.

        Parameters
        ----------
        certificate : Certificate
            Of the solver's gap.
        left : float
            By what factor it misses what is asked for.
        """
        by_residual = self.criterion.residual is not None
        error = certificate.residual if by_residual else certificate.errors[2]
        nearer = error < CALIBRATION.improvement * self.least_refused
        self.refusals = 0 if nearer else self.refusals + 1
        self.least_refused = min(error, self.least_refused)
        share = 1 / left if np.isfinite(left) else 1.0
        self.threshold = share * self.asked
        self._look_later(share)

    def wait_at_saddle(self) -> bool:
        """Note that the state is a saddle, which it may be on its way only; return whether to
        iterate further before anything is done."""
        self.saddles += 1
        self._look_later(0.0)
        return self.saddles % CALIBRATION.waits != 0

    def is_stable_enough(self, progress: Progress) -> bool:
        """Return whether the solver still believes that it is there after its stability was found.

        Parameters
        ----------
        progress : Progress
            With this stability.
        """
        self.asked = measure_of(progress, self.criterion)
        if self.asked < self.threshold:
            return True
        self._look_later(self.threshold / self.asked)
        return False

    def _look_later(self, share: float) -> None:
        """Note when the stability, which changes meanwhile, is looked for next: where the measure
        is this share of what it is, or a bit less."""
        self.look_below = max(share, CALIBRATION.look_again) * self.measure
        self.look_at = self.solver.iterations + CALIBRATION.look_again_after

    @property
    def refused_too_often(self) -> bool:
        """Whether further iterations bring the certificate no nearer."""
        return self.refusals > CALIBRATION.refusals

    def exceeded(self, progress: Progress) -> str | None:
        """Return the status of a load that has to end here, None where it may go on."""
        if not progress.finite:
            return "nonfinite"
        if self.solver.iterations >= self.criterion.max_iterations:
            return "max_iterations"
        refused = np.isfinite(self.least_refused)
        patience = self.solver.patience * (CALIBRATION.patience_at_floor if refused else 1)
        if self.solver.problem.attraction is not None:
            # the energy falls, errors may rise meanwhile
            patience = self.solver.patience * CALIBRATION.patience_with_attraction
        if self.solver.iterations - self.best_at > patience:
            return "stagnated"
        return None


def _may_be_met(
    solver: Solver, progress: Progress, criterion: StoppingCriterion, search: LoadSearch | None
) -> bool:
    """Return whether the certificate may find what takes a look at all points: the area, and the
    target of a search."""
    if criterion.accuracy is None:
        return True
    if search is None:
        return area_may_be_met(solver, progress, criterion.accuracy)
    return search.may_be_met(solver, progress, criterion.accuracy)


def _conclude(
    solver: Solver,
    criterion: StoppingCriterion,
    search: LoadSearch | None,
    guard: SaddleGuard | None,
    reason: str,
    pairs: float,
) -> Outcome:
    """Return the outcome of a load that ends for a reason other than its certificate; it may have
    reached what is asked for all the same."""
    if guard is not None:
        pairs += guard.look()
    certificate = certificate_of(solver, criterion)
    pairs += certificate.pairs
    miss = search.learn(solver, certificate) if search is not None else 0.0
    met = max(error_left(certificate, criterion), miss) < 1
    if met and reason not in ("nonfinite", "interrupted"):
        reason = _status_of(certificate, criterion)
    return Outcome(reason, certificate, pairs)


def certificate_of(solver: Solver, criterion: StoppingCriterion) -> Certificate:
    """Certify the solver's gap; solver.p becomes its pressure. Collective.

    Parameters
    ----------
    solver : Solver
        At a gap.
    criterion : StoppingCriterion
        What the certificate has to give, and in which precision.

    Returns
    -------
    Certificate
        The same on all ranks.
    """
    if criterion.in_turn:
        solver.make_room()
    certificate = certify(
        solver.problem_now,
        solver.g,
        solver.p,
        solver.levels,
        criterion.certificate_dtype,
        criterion.duality,
        solver.stability,
    )
    if criterion.in_turn:
        solver.grid.forget_fft(criterion.certificate_dtype)
        solver.take_room()
    if criterion.closes and certificate.contact == solver.N:
        _, _, pressure_error = certificate.errors
        certificate = replace(certificate, errors=(0.0, 0.0, pressure_error))
    return certificate


def measure_of(progress: Progress, criterion: StoppingCriterion) -> float:
    """Return the solver's own measure of the error over what is asked for.

    Parameters
    ----------
    progress : Progress
        Of the solver.
    criterion : StoppingCriterion
        What is asked for.

    Returns
    -------
    float
        Below 1 the solver believes that it is there; infinite after a step in which it has not
        estimated its errors.
    """
    if criterion.residual is not None:
        return progress.residual / criterion.residual
    estimate = progress.estimate
    if estimate is None:
        return np.inf
    errors = (0.0, min(estimate.gap, 1.0), estimate.pressure)
    return _largest_over_tolerance(criterion, errors, estimate.attainable)


def error_left(certificate: Certificate, criterion: StoppingCriterion) -> float:
    """Return the certified error over what is asked for.

    Parameters
    ----------
    certificate : Certificate
        Of the solver's gap.
    criterion : StoppingCriterion
        What is asked for.

    Returns
    -------
    float
        Below 1 that is reached.
    """
    if not certificate.finite or certificate.stability <= 0:
        return np.inf
    if criterion.residual is not None:
        return certificate.residual / criterion.residual
    return _largest_over_tolerance(criterion, certificate.errors, certificate.attainable)


def _largest_over_tolerance(
    criterion: StoppingCriterion,
    errors: tuple[float, float, float],
    attainable: tuple[float, float],
) -> float:
    """Return the largest error over the tolerance, of those that iterations make smaller."""
    at_best = (0.0, *attainable)
    errors_left = [
        error for error, best in zip(errors, at_best, strict=True) if best < criterion.tolerance
    ]
    return max(errors_left, default=0.0) / criterion.tolerance


def _status_of(certificate: Certificate, criterion: StoppingCriterion) -> str:
    """Return the status of a solution that is as accurate as it will be."""
    met = criterion.residual is not None or max(certificate.errors) < criterion.tolerance
    return "converged" if met else "stagnated"
