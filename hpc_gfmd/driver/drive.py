"""The only loop: iterate a solver until its load is solved, a limit is exceeded or the run has to
stop, and certify the result."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..certificate.certificate import Certificate, certify
from ..certificate.criterion import StoppingCriterion
from .target import Target

if TYPE_CHECKING:
    from ..solvers.base import Progress, Solver
    from .branches import SaddleGuard

    Watch = Callable[[int, Progress], Any]


@dataclass(frozen=True)
class LoopCalibration:
    """When a certificate is computed, and when a solver counts as stagnated.

    A certificate alone decides that a load is solved; these numbers cost or save FFT pairs only.
    "Measure" is the error that the solver estimates, over the requested one.
    """

    refusals: int = 5  # refused certificates without a smaller error until the solver has stagnated
    # Factor on the solver's patience once a certificate was refused: then only rounding errors are
    # left.
    patience_at_floor: float = 1 / 6
    # factor by which a measure or error must decrease to count as progress
    improvement: float = 0.9
    # after a too small stability: share to which the measure decreases before the next
    look_again: float = 0.3
    look_again_after: int = 10  # or number of iterations
    # By how much the errors are expected to decrease in a step that is made together with a
    # certificate: to 0.2 to 0.5. Measured on 394 loads: about 2 % more pairs at 2
    ahead: float = 3.0
    waits: int = 3  # looks at a saddle after which the solver is kicked away from it
    # relative change of the points in contact that counts as progress, with attraction
    avalanche: float = 0.01
    # Factor on the solver's patience with an attraction: on the way from a saddle the errors rise
    # for a while.
    patience_with_attraction: float = 2.5


CALIBRATION = LoopCalibration()


class Outcome(NamedTuple):
    """How the iterations of a load have ended: a status (see `contact.Contact`), the certificate of
    the final gap, whose recomputed pressure is the solver's p, and the FFT pairs of certificates
    and stabilities.
    """

    status: str
    certificate: Certificate
    pairs: float


def drive(
    solver: Solver,
    criterion: StoppingCriterion,
    watch: Watch | None = None,
    target: Target | None = None,
    guard: SaddleGuard | None = None,
    certificate: Certificate | None = None,
) -> Outcome:
    """Iterate a started solver until a certificate meets the criterion, or until it has to end.

    `watch(iterations, progress)` is called before every step unless a certificate is due; a true
    value ends the iterations as "interrupted". `target` may change the mean pressure, `guard`
    (required with an attraction) computes the stability and leaves saddles; `certificate` is that
    of the start if it may be accurate enough. The solver's state becomes the solution. Collective.
    """
    target = target or Target(solver.p0)
    if certificate is not None:
        error = criterion.left(certificate)
        if max(error, target.judge(solver, certificate)) < 1:
            solver.uKu = certificate.uKu  # the next load may go on from here
            return Outcome(criterion.status(certificate), certificate, 0.0)
        solver.restart(certificate)
        target.correct(solver, certificate, error < 1)
    limits = Limits(solver, criterion)
    solver.stability = None  # that of the load before is not that of this one
    pairs = 0.0
    while True:
        if solver.is_separated:
            if not target.touches:
                return Outcome("separated", Certificate(errors=(0.0, 0.0, 0.0)), pairs)
            if not target.bring_back(solver):
                return Outcome("stagnated", _of_lost_contact(solver), pairs)
            limits.begin_again()
            solver.step()
            continue
        progress = solver.progress()
        if target.follow(solver, progress):
            limits.begin_again()
            progress = solver.progress()
        limits.note(progress)
        may_be_solved = limits.ask_for_certificate(progress) and _may_be_met(
            solver, progress, criterion, target
        )
        goes_ahead = (
            not may_be_solved
            and limits.ask_ahead(progress)
            and _may_be_met(solver, progress.reduced(CALIBRATION.ahead), criterion, target)
        )
        if goes_ahead:
            limits.went_ahead = True
            solver.step_ahead()
        elif not may_be_solved:
            reason = limits.exceeded(progress)
            if reason is None and watch is not None and watch(solver.iterations, progress):
                reason = "interrupted"
            if reason is not None:
                outcome = _conclude(solver, criterion, target, guard, reason, pairs)
                if reason != "stagnated" or not _goes_elsewhere(solver, criterion, target, outcome):
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
        error = criterion.left(certificate)
        miss = target.judge(solver, certificate)
        if max(error, miss) < 1:
            if guard is None or solver.problem.spring == 0:
                solver.uKu = certificate.uKu  # the next load may go on from here
                return Outcome(criterion.status(certificate), certificate, pairs)
            pairs += guard.look()  # for modes that a search with an early end does not see
            if not guard.at_saddle:
                certificate = replace(certificate, stability=guard.stability)
                return Outcome(criterion.status(certificate), certificate, pairs)
        if not goes_ahead:
            limits.note_refusal(certificate, max(error, miss, 1.0))
        if limits.refused_too_often:
            return Outcome("stagnated", certificate, pairs)
        if guard is not None and guard.leave_saddle():
            limits.begin_again()
            continue
        solver.stability = None
        solver.after_certificate(certificate)
        if target.correct(solver, certificate, error < 1):
            limits.begin_again()
        solver.step()


def _of_lost_contact(solver: Solver) -> Certificate:
    """Return a certificate without content of separated bodies that should touch."""
    return Certificate(
        errors=(np.inf, np.inf, np.inf),
        residual=np.inf,
        gap_mean=solver.progress().gap_mean,
        energy=np.nan,
    )


def _goes_elsewhere(
    solver: Solver, criterion: StoppingCriterion, target: Target, outcome: Outcome
) -> bool:
    """Let a target change the load if the iterations stagnated at a sufficiently accurate solution;
    return whether it changed p0 of the solver. Collective."""
    certificate = outcome.certificate
    is_solved = criterion.left(certificate) < 1 and criterion.status(certificate) == "converged"
    if outcome.status != "stagnated" or not is_solved:
        return False
    return target.correct(solver, certificate, is_solved)


def _leaves_saddle(limits: Limits, guard: SaddleGuard) -> bool:
    """Let the guard kick the solver away from a saddle if it has been there for long enough; return
    whether it did (gap and pressure are new then, and `limits` begins again). Collective."""
    if not guard.at_saddle or limits.wait_at_saddle() or not guard.leave_saddle():
        return False
    limits.begin_again()
    return True


class Limits:
    """Decides when a certificate is computed, and when a solver has iterated long enough.

    A certificate is due once the measure (`StoppingCriterion.measure`) is below a threshold, 1 at
    first, which a refusal lowers by the factor by which errors were too large. `measure` is that of
    the progress noted last, `asked` the same with the stability in it once `is_stable_enough` was
    asked.
    """

    def __init__(self, solver: Solver, criterion: StoppingCriterion):
        self.solver = solver
        self.criterion = criterion
        self.begin_again()

    def begin_again(self) -> None:
        """Forget all progress and all refused certificates, because load or state have changed."""
        self.refusals = 0
        self.went_ahead = False  # whether a step and a certificate were made together
        self.saddles = 0
        self.least_refused = np.inf  # the smallest error that the certificate refused
        self.threshold = 1.0  # of the measure, with the stability in it, for a certificate
        self.look_below = np.inf  # of the measure without it, for a look at the stability
        self.look_at = 0  # iterations from which on there is one anyway
        self.best = np.inf
        self.contact = 0.0
        self.best_at = self.solver.iterations

    def note(self, progress: Progress) -> None:
        """Record the progress of an iteration: its measure, and whether it is the best so far."""
        self.measure = self.asked = self.criterion.measure(progress.residual, progress.estimate)
        if self.measure < CALIBRATION.improvement * self.best:
            self.best = self.measure
            self.best_at = self.solver.iterations
        if self.solver.problem.attraction is not None:
            self._note_contact(progress.contact)

    def _note_contact(self, contact: float) -> None:
        """Count a change of the points in contact by more than a percent as progress.

        With an attraction the contact may close or open as an avalanche, while errors rise.
        """
        if abs(contact - self.contact) > max(CALIBRATION.avalanche * self.contact, 1):
            self.contact = contact
            self.best_at = self.solver.iterations

    def ask_for_certificate(self, progress: Progress) -> bool:
        """Return whether a certificate is due for the progress that was noted last."""
        is_time = self.measure < self.look_below or self.solver.iterations >= self.look_at
        return progress.finite and self.measure < self.threshold and is_time

    def ask_ahead(self, progress: Progress) -> bool:
        """Return whether the next step and a certificate may be made together.

        Once until `begin_again`, since the line search does not shorten this step. Not with an
        attraction, where the stability comes before a certificate.
        """
        solver = self.solver
        can = solver.goes_ahead and solver.problem.attraction is None and not self.went_ahead
        is_near = progress.finite and self.measure < CALIBRATION.ahead * self.threshold
        return can and is_near and solver.iterations < self.criterion.max_iterations

    def note_refusal(self, certificate: Certificate, left: float) -> None:
        """Lower the threshold after a certificate whose error was `left` times the requested
        one.
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
        """Count a look at a saddle, postpone the next certificate, and return whether to iterate
        further first.

        The solver may leave the saddle by itself: two of three calls return True.
        """
        self.saddles += 1
        self._look_later(0.0)
        return self.saddles % CALIBRATION.waits != 0

    def is_stable_enough(self, progress: Progress) -> bool:
        """Return whether a certificate is due with the stability in the estimate, or postpone
        it.
        """
        self.asked = self.criterion.measure(progress.residual, progress.estimate)
        if self.asked < self.threshold:
            return True
        self._look_later(self.threshold / self.asked)
        return False

    def _look_later(self, share: float) -> None:
        """Postpone the next certificate until the measure has decreased to this share of its value
        (0.3 at least), or for ten iterations."""
        self.look_below = max(share, CALIBRATION.look_again) * self.measure
        self.look_at = self.solver.iterations + CALIBRATION.look_again_after

    @property
    def refused_too_often(self) -> bool:
        """Whether too many certificates in a row were refused without a smaller error."""
        return self.refusals > CALIBRATION.refusals

    def exceeded(self, progress: Progress) -> str | None:
        """Return the status with which the iterations have to end, or None. Call `note` before.

        It is "nonfinite", "max_iterations", or "stagnated" after too many iterations without
        progress.
        """
        if not progress.finite:
            return "nonfinite"
        if self.solver.iterations >= self.criterion.max_iterations:
            return "max_iterations"
        refused = np.isfinite(self.least_refused)
        patience = self.solver.patience * (CALIBRATION.patience_at_floor if refused else 1)
        if self.solver.problem.attraction is not None:
            # the energy falls, errors may rise meanwhile
            patience *= CALIBRATION.patience_with_attraction
        if self.solver.iterations - self.best_at > patience:
            return "stagnated"
        return None


def _may_be_met(
    solver: Solver, progress: Progress, criterion: StoppingCriterion, target: Target
) -> bool:
    """Return whether a certificate may find the area accurate and the target met.

    This takes a pass over all points, unlike the measure. True if a residual is requested.
    Collective.
    """
    if criterion.accuracy is None:
        return True
    return target.may_be_met(solver, progress, criterion.largest_of_result)


def _conclude(
    solver: Solver,
    criterion: StoppingCriterion,
    target: Target,
    guard: SaddleGuard | None,
    reason: str,
    pairs: float,
) -> Outcome:
    """Certify the final state of a load that ends for `reason`, and return its outcome. Collective.

    If the certificate meets the criterion all the same, its status replaces the reason (except for
    "nonfinite" and "interrupted"). pairs: of the certificates so far.
    """
    if guard is not None:
        pairs += guard.look()
    certificate = certificate_of(solver, criterion)
    pairs += certificate.pairs
    miss = target.judge(solver, certificate)
    met = max(criterion.left(certificate), miss) < 1
    if met and reason not in ("nonfinite", "interrupted"):
        reason = criterion.status(certificate)
    return Outcome(reason, certificate, pairs)


def certificate_of(solver: Solver, criterion: StoppingCriterion) -> Certificate:
    """Certify the solver's gap, and overwrite its pressure with the recomputed one. Collective.

    The fields of the levels are overwritten, too, and with `criterion.in_turn` the last step is
    lost: the solver needs `restart` before its next step. With `criterion.closes` and all points in
    contact the errors of area and mean gap are 0.
    """
    with solver.room() if criterion.in_turn else nullcontext():
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
    if criterion.closes and certificate.contact == solver.N:
        _, _, pressure_error = certificate.errors
        certificate = replace(certificate, errors=(0.0, 0.0, pressure_error))
    return certificate
