"""The only loop: iterate a solver until its target, its limits or a request to stop, and certify
what it returns."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..certificate.certificate import Certificate, certify
from ..certificate.criterion import StoppingCriterion
from .load import GivenLoad

if TYPE_CHECKING:
    from ..solvers.base import Progress, Solver

    Watch = Callable[[int, Progress], Any]

UNKNOWN = 1.0  # an error measure that says nothing


@dataclass(frozen=True)
class Calibration:
    """When a solver is certified, and when it counts as stagnated.

    What ends an iteration is the certificate: these numbers cost or save pairs only.

    Attributes
    ----------
    check_from, check_growth : float
        The iteration at which a solver without error estimates is certified first, and the factor
        from one such iteration to the next.
    refusals : int
        Times that the certificate may refuse without having come nearer, before the solver counts
        as stagnated.
    floor : float
        Share of its patience that a solver has that believed that it was there: only rounding
        errors are left.
    improvement : float
        Of the error measure: what is progress.
    """

    check_from: int = 10
    check_growth: float = 1.25
    refusals: int = 5
    floor: float = 1 / 6
    improvement: float = 0.9


CALIBRATION = Calibration()


@dataclass
class LoopState:
    """What the loop remembers of a load beside the solver's state: both make a checkpoint."""

    checks: float = 0.0  # FFT pairs that certificates took
    refusals: int = 0
    refused: float = np.inf  # the smallest error of the pressure that the certificate refused
    threshold: float = 1.0  # the solver's own error measure at which it is asked
    next_check: float = CALIBRATION.check_from
    best: float = np.inf  # error measure, and the iteration that reached it
    best_at: int = 0

    def begin_again(self, iterations: int) -> None:
        """Forget what was reached so far: the load has changed."""
        self.refusals, self.refused, self.threshold = 0, np.inf, 1.0
        self.best, self.best_at = np.inf, iterations


def drive(
    solver: Solver,
    target: StoppingCriterion,
    watch: Watch | None = None,
    loop: LoopState | None = None,
    load: GivenLoad | None = None,
) -> tuple[str, Certificate, float]:
    """Iterate; return the status of the load, see contact.Contact, its certificate, and the FFT
    pairs that certificates took. watch(iterations, progress), if given, is called after every step
    and returns a true value to stop.

    load: a search for it, where it is not given; loop: the LoopState of this load where its
    beginning was before a checkpoint, which is kept up to date. On return solver.p is the fresh
    pressure of the certificate, in the solver's precision.
    """
    loop = loop or LoopState(best_at=solver.iterations)
    load = load or GivenLoad(solver.p0)
    progress = solver.progress()
    while True:
        status = None
        done = solver.iterations
        if load.adjust(solver, progress):
            loop.begin_again(done)
            progress = solver.progress()
        measure = _measure(progress, target)
        unknown = progress.estimate is None and target.residual is None
        falling = progress.residual if measure == UNKNOWN else measure
        if falling < CALIBRATION.improvement * loop.best:
            loop.best, loop.best_at = falling, done
        if not progress.finite:
            status = "nonfinite"
        elif (
            measure < loop.threshold
            and (target.accuracy is None or load.may_be_met(solver, progress, target.accuracy))
        ) or (unknown and done >= loop.next_check):
            certificate = certificate_of(solver, target)
            loop.checks += certificate.pairs
            solved = _left(target, certificate)
            left = max(solved, load.learn(solver, certificate))
            if left < 1:
                return _status(target, certificate), certificate, loop.checks
            if measure < loop.threshold:
                error = certificate.errors[2] if target.residual is None else certificate.residual
                loop.refusals = (
                    loop.refusals + 1 if not error < CALIBRATION.improvement * loop.refused else 0
                )
                if loop.refusals > CALIBRATION.refusals:
                    return "stagnated", certificate, loop.checks
                loop.threshold = measure / left if np.isfinite(left) else measure
                loop.refused = min(error, loop.refused)
            if progress.estimate is not None:
                solver.refresh(certificate.uKu)
            if load.correct(solver, certificate, solved < 1):
                loop.begin_again(done)
            loop.next_check = CALIBRATION.check_growth * done + 1
        elif done >= target.max_iterations:
            status = "max_iterations"
        elif done - loop.best_at > solver.patience * (
            1 if np.isinf(loop.refused) else CALIBRATION.floor
        ):
            status = "stagnated"
        elif watch is not None and watch(done, progress):
            status = "interrupted"
        if status is not None:
            certificate = certificate_of(solver, target)
            met = max(_left(target, certificate), load.learn(solver, certificate)) < 1
            if met and status not in ("nonfinite", "interrupted"):
                status = _status(target, certificate)
            return status, certificate, loop.checks + certificate.pairs
        solver.step()
        progress = solver.progress()


def certificate_of(solver: Solver, target: StoppingCriterion) -> Certificate:
    """Return the certificate of the solver's state. Collective."""
    if target.in_turn:
        solver.make_room()
    found = certify(
        solver.problem_now,
        solver.g,
        solver.p,
        solver.levels,
        target.certificate_dtype,
        target.duality,
    )
    if target.in_turn:
        solver.grid.forget_fft(target.certificate_dtype)
        solver.take_room()
    if target.closes and found.contact == solver.N:
        found = replace(found, errors=(0.0, 0.0, found.errors[2]))
    return found


def _measure(progress: Progress, target: StoppingCriterion) -> float:
    """Tell how far from the target, by the solver's own numbers: below 1 it believes that it is
    there; UNKNOWN without estimates."""
    if target.residual is not None:
        return progress.residual / target.residual
    if progress.estimate is None:
        return UNKNOWN
    gap, pressure, attainable, *_ = progress.estimate
    return _beyond(target, (0.0, min(gap, 1.0), pressure), attainable)


def _left(target: StoppingCriterion, certificate: Certificate) -> float:
    """Tell how far from the target, by the certificate: below 1 it is reached."""
    if not certificate.finite:
        return np.inf
    if target.residual is not None:
        return certificate.residual / target.residual
    return _beyond(target, certificate.errors, certificate.attainable)


def _beyond(
    target: StoppingCriterion, errors: tuple[float, float, float], attainable: tuple[float, float]
) -> float:
    """Return the largest over what is asked for of the errors that iterations make smaller."""
    best = (0.0, *attainable)
    left = [e for e, least in zip(errors, best, strict=True) if least < target.tolerance]
    return max(left, default=0.0) / target.tolerance


def _status(target: StoppingCriterion, certificate: Certificate) -> str:
    """Tell the status of what is as accurate as it will be."""
    asked = target.residual is not None or max(certificate.errors) < target.tolerance
    return "converged" if asked else "stagnated"
