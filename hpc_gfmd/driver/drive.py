"""The only loop: iterate a solver until its target, its limits or a request to stop, and judge what it returns."""

from dataclasses import dataclass

import numpy as np

from .certificate import Certificate, certify

CHECK_FROM, CHECK_GROWTH = 10, 1.25  # iterations at which a solver without error estimates is judged: each 1.25 times later
REFRESHES = 5  # times that a solver may be set right by a fresh pressure before it counts as stagnated
ROUNDING_SAFETY = 1.25  # on what rounding errors add to the error of the pressure
SURE = 0.01  # expected number of points on the wrong side below which there is none
NEAR = 12.0  # times its rms: the error of the pressure of a single point
DEMAND = 0.1  # how much more accurate to become where points are too close to changing sides to tell the area
IMPROVEMENT = 0.9  # of the error measure within `patience` iterations is progress
UNKNOWN = 1.0


@dataclass(frozen=True)
class Target:
    """Either accuracy (relative, of area, mean gap and pressure) or residual; max_iterations per load; judged_in: precision of the
    certificate; duality: whether the certificate has to give the duality gap."""

    accuracy: float | None = None
    residual: float | None = None
    max_iterations: int = 100_000
    judged_in: type = np.float64
    duality: bool = False


@dataclass
class Course:
    """What the loop remembers of a load beside the solver's state: both make a checkpoint."""

    checks: float = 0.0  # FFT pairs that judging took
    refreshes: int = 0
    demand: float = 1.0
    next_check: float = CHECK_FROM
    best: float = np.inf  # error measure, and the iteration that reached it
    best_at: int = 0


@dataclass(frozen=True)
class Outcome:
    """status: converged, stagnated, max_iterations, nonfinite, interrupted; errors: estimated relative errors of (area, mean gap,
    pressure); check_pairs: FFT pairs that judging took."""

    status: str
    errors: tuple[float, float, float]
    certificate: Certificate | None
    check_pairs: float


def drive(solver, target, watch=None, course=None):
    """Iterate. watch(iterations, progress), if given, is called after every step and returns a true value to stop.

    course: the Course of this load where its beginning was before a checkpoint; it is kept up to date.
    On return solver.p is the fresh pressure of the certificate, in the solver's precision.
    """
    course = course or Course(best_at=solver.iterations)
    progress = solver.progress()
    while True:
        status = None
        done = solver.iterations
        measure = _measure(progress, target)
        falling = progress.residual if measure == UNKNOWN else measure
        if falling < IMPROVEMENT * course.best:
            course.best, course.best_at = falling, done
        if not progress.finite:
            status = "nonfinite"
        elif measure < course.demand or (progress.estimates is None and target.residual is None and done >= course.next_check):
            certificate = _judged(solver, progress, target)
            course.checks += certificate.pairs
            errors = _errors(progress, certificate, solver.N)
            if _reached(target, errors, certificate):
                return Outcome("converged", errors, certificate, course.checks)
            if measure < course.demand:
                if target.accuracy is not None and max(errors[1:]) < target.accuracy:
                    course.demand *= DEMAND
                course.refreshes += 1
                if course.refreshes > REFRESHES:
                    return Outcome("stagnated", errors, certificate, course.checks)
                solver.refresh()
            course.next_check = CHECK_GROWTH * done + 1
        elif done >= target.max_iterations:
            status = "max_iterations"
        elif done - course.best_at > solver.patience:
            status = "stagnated"
        elif watch is not None and watch(done, progress):
            status = "interrupted"
        if status is not None:
            certificate = _judged(solver, progress, target)
            errors = _errors(progress, certificate, solver.N)
            if status not in ("nonfinite", "interrupted") and _reached(target, errors, certificate):
                status = "converged"
            return Outcome(status, errors, certificate, course.checks + certificate.pairs)
        solver.step()
        progress = solver.progress()


def _judged(solver, progress, target):
    """The certificate of the solver's state; where the area is claimed to be right to the point, with the points that may be wrong."""
    near, estimated = 0.0, _estimated(progress)
    if estimated and progress.contact > 0 and progress.estimates[0] < 1 / progress.contact:
        near = NEAR * progress.estimates[2] * solver.pressure_rms
    return certify(solver.problem_now, solver.g, solver.p, target.judged_in, dual=target.duality or not estimated, near=near)


def _estimated(progress):
    """Whether the solver knows its errors; the duality gap has to bound that of the mean gap otherwise."""
    return progress.estimates is not None and bool(np.isfinite(progress.estimates).all())


def _measure(progress, target):
    """How far from the target, by the solver's own numbers: below 1 it believes that it is there; UNKNOWN without estimates."""
    if target.residual is not None:
        return progress.residual / target.residual
    if progress.estimates is None:
        return UNKNOWN
    return max(progress.estimates) / target.accuracy


def _errors(progress, certificate, N):
    """Estimated relative errors of area, mean gap and pressure: the solver's estimates with what the certificate says."""
    if not _estimated(progress):
        pressure, gap = 2 * certificate.pressure, certificate.gap_bound
        # Points whose pressure or gap is within the pressure error of changing sides.
        n_c = certificate.contact
        area = (pressure + (1.0 / n_c if pressure * n_c > SURE else 0.0)) if n_c else np.inf
        return area, gap, pressure
    area, gap, pressure = progress.estimates
    # What the fresh pressure has more out of contact than the solver's is rounding, spread evenly.
    more = max(1 - (progress.residual / certificate.residual)**2, 0.0) if certificate.residual > 0 else 0.0
    area += certificate.near / max(certificate.contact, 1)
    return area, gap, float(np.hypot(pressure, ROUNDING_SAFETY * certificate.pressure * np.sqrt(more)))


def _reached(target, errors, certificate):
    if not certificate.finite:
        return False
    if target.residual is not None:
        return certificate.residual < target.residual
    return max(errors) < target.accuracy
