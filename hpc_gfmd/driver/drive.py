"""The only loop: iterate a solver until its load is solved or has to end, and certify that.

After every step the target may change the mean pressure. Once the errors that the solver estimates
meet the criterion, a certificate is computed, which accepts the state or sends the solver on from
it. A load also ends if it makes no progress any more (`Limits`), is interrupted, or separates.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..certificate.certificate import Certificate
from ..certificate.criterion import StoppingCriterion
from .certifier import Certifier
from .target import Target

if TYPE_CHECKING:
    from ..solvers.base import Progress, Solver
    from .branches import SaddleGuard

    Watch = Callable[[int, Progress], Any]


IN_DOUBLE = Certifier(np.dtype(np.float64))
# When a certificate is computed, and when a solver counts as stagnated. A certificate alone decides
# that a load is solved; these numbers cost or save FFT pairs only. The measure is the error that
# the solver estimates, over the requested one.
REFUSALS = 5  # refused certificates without a smaller error until the solver has stagnated
# factor on the solver's patience once a certificate was refused: only rounding errors are left
AT_FLOOR = 1 / 6
IMPROVEMENT = 0.9  # factor by which a measure or error must decrease to count as progress
# after a too small stability: share to which the measure decreases before the next look,
LOOK_AGAIN = 0.3
LOOK_AGAIN_AFTER = 10  # or number of iterations
# By how much the errors are expected to decrease in a step that is made together with a
# certificate, and in another one if that is refused, after which the solver has forgotten its last
# step. Measured: to 0.2 to 0.5. With 4 for the first one self-affine walls take 1 % fewer pairs and
# all walls of the campaign 1 % more; without the second one self-affine walls take 1 % more.
AHEAD = 3.0, 2.5
WAITS = 3  # looks at a saddle per kick away from it: the solver may leave by itself
AVALANCHE = 0.01  # relative change of the points in contact that is progress, with attraction
# factor on the patience with an attraction: on the way from a saddle errors rise for a while
WITH_ATTRACTION = 2.5


class Outcome(NamedTuple):
    """How a load has ended: status (see `contact.Contact`), certificate of the solver's state, and
    the FFT pairs of certificates and stabilities.
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
    certifier: Certifier = IN_DOUBLE,
) -> Outcome:
    """Iterate a started solver until a certificate meets the criterion, or until it has to end.
    Collective.

    watch(iterations, progress) is called before a step and may end the load as "interrupted".
    `target` may change p0; `guard`, required with an attraction, computes the stability and leaves
    saddles; `certificate` is that of the start, if it may be accurate enough; `certifier` makes the
    others. The solver's state becomes the solution.
    """
    target = target or Target(solver.state.p0)
    loop = Loop(solver, criterion, watch, target, guard, certifier)
    outcome = None if certificate is None else loop.begin_with(certificate)
    while outcome is None:
        outcome = loop.iterate()
    return outcome


class Loop:
    """The iterations of one load; `pairs` are the FFT pairs of certificates and stabilities so far.
    All methods are collective."""

    def __init__(
        self,
        solver: Solver,
        criterion: StoppingCriterion,
        watch: Watch | None,
        target: Target,
        guard: SaddleGuard | None,
        certifier: Certifier,
    ):
        self.solver = solver
        self.criterion = criterion
        self.watch = watch
        self.target = target
        self.guard = guard
        self.certifier = certifier
        self.limits = Limits(solver, criterion)
        self.pairs = 0.0
        solver.state.stability = None  # that of the load before is not that of this one

    def begin_with(self, certificate: Certificate) -> Outcome | None:
        """Return the outcome if the start is the solution, by its certificate; else begin there."""
        certificate = self.target.certificate_of(self.solver, certificate)
        error = self.criterion.left(certificate)
        if max(error, self.target.judge(self.solver, certificate)) < 1:
            return self._solved(certificate)
        self.solver.restart()
        self.target.correct(self.solver, certificate, error < 1)
        return None

    def iterate(self) -> Outcome | None:
        """Make a step, and a certificate before or with it if one is due; return the outcome if the
        load has ended."""
        solver = self.solver
        limits = self.limits
        if solver.is_separated:
            return self._bring_back()
        progress = solver.progress()
        if self.target.follow(solver, progress):
            limits.begin_again()
            progress = solver.progress()
        limits.note(progress)
        is_due = limits.ask_for_certificate(progress)
        decrease = limits.ask_ahead(progress)
        goes_ahead = decrease > 1 and self._may_be_met(progress.reduced(decrease))
        if decrease > 1:  # what a further step would not reach is not reached now
            is_due = is_due and goes_ahead
        if is_due and self._may_be_met(progress):
            return self._look()
        if goes_ahead:
            limits.times_ahead += 1
            solver.step_ahead()
            return self._look(ahead=True)
        reason = limits.exceeded(progress)
        if reason is None and self.watch is not None and self.watch(solver.iterations, progress):
            reason = "interrupted"
        outcome = None if reason is None else self._conclude(reason)
        if outcome is None:
            solver.step()
        return outcome

    def _may_be_met(self, progress: Progress) -> bool:
        """Return whether a certificate may find area and target accurate, by a pass over all
        points; True if a residual is requested.
        """
        if self.criterion.accuracy is None:
            return True
        return self.target.may_be_met(self.solver, progress, self.criterion.largest_of_result)

    def _bring_back(self) -> Outcome | None:
        """Let the target press separated bodies together again if they have to touch, and make a
        step; else return the outcome."""
        if not self.target.touches:
            nothing = Certificate(errors=(0.0, 0.0, 0.0))
            return Outcome("separated", nothing, self.pairs)
        if not self.target.bring_back(self.solver):
            return Outcome("stagnated", _of_lost_contact(self.solver), self.pairs)
        self.limits.begin_again()
        self.solver.step()
        return None

    def _look(self, ahead: bool = False) -> Outcome | None:
        """Return the outcome if a certificate accepts the state; else leave it by a step, to
        another load, or from a saddle. ahead: the step was made without its pressure.
        """
        solver = self.solver
        guard = self.guard
        limits = self.limits
        if guard is not None:
            measure = limits.measure if self.criterion.residual is None else 0.0
            self.pairs += guard.look(measure)
            if guard.at_saddle and not limits.wait_at_saddle() and guard.leave_saddle():
                limits.begin_again()
                return None
            if guard.at_saddle or not limits.is_stable_enough(solver.progress()):
                solver.state.stability = None
                solver.step()
                return None
        certificate = self._certificate()
        error = self.criterion.left(certificate)
        miss = self.target.judge(solver, certificate)
        outcome = self._solved(certificate) if max(error, miss) < 1 else None
        if outcome is not None:
            return outcome
        if not ahead:
            limits.note_refusal(certificate, max(error, miss, 1.0))
        if limits.refused_too_often:
            return Outcome("stagnated", certificate, self.pairs)
        if guard is not None and guard.leave_saddle():
            limits.begin_again()
            return None
        solver.state.stability = None
        solver.after_certificate()
        moved = self.target.correct(solver, certificate, error < 1)
        if moved:
            limits.begin_again()
        if moved or not (ahead and limits.may_go_ahead_again(max(error, miss))):
            solver.step()
        return None

    def _certificate(self) -> Certificate:
        certificate = self.certifier.certify(self.solver)
        self.pairs += certificate.pairs
        return self.target.certificate_of(self.solver, certificate)

    def _solved(self, certificate: Certificate) -> Outcome | None:
        """Return the outcome of an accurate state; None if the guard does not confirm it."""
        if self.guard is not None:
            confirmed, pairs = self.guard.confirm(certificate)
            self.pairs += pairs
            if confirmed is None:
                return None
            certificate = confirmed
        return Outcome(self.criterion.status(certificate), certificate, self.pairs)

    def _conclude(self, reason: str) -> Outcome | None:
        """Certify the final state of a load that ends for `reason`, and return its outcome; None if
        the target goes on elsewhere. A met criterion replaces the reason, except "nonfinite" and
        "interrupted".
        """
        if self.guard is not None:
            self.pairs += self.guard.look()
        certificate = self._certificate()
        error = self.criterion.left(certificate)
        status = self.criterion.status(certificate)
        miss = self.target.judge(self.solver, certificate)
        if max(error, miss) < 1 and reason not in ("nonfinite", "interrupted"):
            reason = status
        is_missed = reason == "stagnated" and error < 1 and status == "converged"
        if is_missed and self.target.correct(self.solver, certificate, solved=True):
            self.limits.begin_again()
            return None
        return Outcome(reason, certificate, self.pairs)


def _of_lost_contact(solver: Solver) -> Certificate:
    """Return a certificate without content of separated bodies that should touch."""
    return Certificate(
        errors=(np.inf, np.inf, np.inf),
        residual=np.inf,
        gap_mean=solver.progress().gap_mean,
        energy=np.nan,
    )


class Limits:
    """Decides when a certificate is due, and when a solver has iterated long enough.

    A certificate is due below a threshold of the measure (`StoppingCriterion.measure`), at first 1,
    which refusals lower. `measure`: of the last progress; `asked`: with the stability in it.
    """

    def __init__(self, solver: Solver, criterion: StoppingCriterion):
        self.solver = solver
        self.criterion = criterion
        self.begin_again()

    def begin_again(self) -> None:
        """Forget all progress and all refused certificates, because load or state have changed."""
        self.refusals = 0
        self.refused_at = -1  # iterations of the last state whose certificate was refused
        self.times_ahead = 0  # how often a step and a certificate were made together
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
        if self.measure < IMPROVEMENT * self.best:
            self.best = self.measure
            self.best_at = self.solver.iterations
        if self.solver.problem.attraction is not None:
            self._note_contact(progress.contact)

    def _note_contact(self, contact: float) -> None:
        """Count a change of the contact by over a percent as progress, as in an avalanche."""
        if abs(contact - self.contact) > max(AVALANCHE * self.contact, 1):
            self.contact = contact
            self.best_at = self.solver.iterations

    def ask_for_certificate(self, progress: Progress) -> bool:
        """Return whether a certificate is due for the progress that was noted last."""
        iterations = self.solver.iterations
        is_time = self.measure < self.look_below or iterations >= self.look_at
        is_new = iterations != self.refused_at
        return progress.finite and self.measure < self.threshold and is_time and is_new

    def ask_ahead(self, progress: Progress) -> float:
        """Return by how much the errors are expected to decrease in the next step if it may be made
        together with a certificate, else 1: only AHEAD times until `begin_again`, as the line
        search does not shorten this step; not with an attraction.
        """
        solver = self.solver
        can = solver.goes_ahead and solver.problem.attraction is None and progress.finite
        is_left = self.times_ahead < len(AHEAD)
        if not (can and is_left) or solver.iterations >= self.criterion.max_iterations:
            return 1.0
        decrease = AHEAD[self.times_ahead]
        return decrease if self.measure < decrease * self.threshold else 1.0

    def may_go_ahead_again(self, left: float) -> bool:
        """Return whether the step after a refused certificate with `left` times the requested error
        may be made ahead, too; if not, no further one is.
        """
        self.refused_at = self.solver.iterations
        is_near = self.times_ahead < len(AHEAD) and left < AHEAD[self.times_ahead]
        if not is_near:
            self.times_ahead = len(AHEAD)
        return is_near

    def note_refusal(self, certificate: Certificate, left: float) -> None:
        """Lower the threshold after a certificate with `left` times the requested error."""
        by_residual = self.criterion.residual is not None
        error = certificate.residual if by_residual else certificate.errors[2]
        nearer = error < IMPROVEMENT * self.least_refused
        self.refusals = 0 if nearer else self.refusals + 1
        self.least_refused = min(error, self.least_refused)
        share = 1 / left if np.isfinite(left) else 1.0
        self.threshold = share * self.asked
        self._look_later(share)

    def wait_at_saddle(self) -> bool:
        """Count a look at a saddle, and return whether to iterate on first, as two of three times:
        the solver may leave by itself.
        """
        self.saddles += 1
        self._look_later(0.0)
        return self.saddles % WAITS != 0

    def is_stable_enough(self, progress: Progress) -> bool:
        """Return whether a certificate is due with the stability, or postpone it."""
        self.asked = self.criterion.measure(progress.residual, progress.estimate)
        if self.asked < self.threshold:
            return True
        self._look_later(self.threshold / self.asked)
        return False

    def _look_later(self, share: float) -> None:
        """Postpone the next certificate to this share of the measure, or for ten iterations."""
        self.look_below = max(share, LOOK_AGAIN) * self.measure
        self.look_at = self.solver.iterations + LOOK_AGAIN_AFTER

    @property
    def refused_too_often(self) -> bool:
        """Whether too many certificates in a row were refused without a smaller error."""
        return self.refusals > REFUSALS

    def exceeded(self, progress: Progress) -> str | None:
        """Return the status with which iterations have to end, or None. Call `note` before."""
        if not progress.finite:
            return "nonfinite"
        if self.solver.iterations >= self.criterion.max_iterations:
            return "max_iterations"
        refused = np.isfinite(self.least_refused)
        patience = self.solver.patience * (AT_FLOOR if refused else 1)
        if self.solver.problem.attraction is not None:
            # the energy falls, errors may rise meanwhile
            patience *= WITH_ATTRACTION
        if self.solver.iterations - self.best_at > patience:
            return "stagnated"
        return None
