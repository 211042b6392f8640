"""The only loop: iterate a solver until its target, its limits or a request to stop, and judge what it returns."""

from dataclasses import dataclass

import numpy as np

from .certificate import Certificate, certify

CHECK_FROM, CHECK_GROWTH = 10, 1.25  # iterations at which a solver without error estimates is judged: each 1.25 times later
REFRESHES = 3  # times that a solver may be set right by a fresh pressure before it counts as stagnated
ROUNDING_SAFETY = 1.25  # on what rounding errors add to the error of the pressure
SURE = 0.02  # expected number of points on the wrong side below which there is none
NEAR = 4.0  # times its rms: the error of the pressure of a single point
DEMAND = 0.1  # how much more accurate to become where points are too close to changing sides to tell the area
IMPROVEMENT = 0.9  # of the error measure within `patience` iterations is progress
UNKNOWN = 1.0


@dataclass(frozen=True)
class Target:
    """Either accuracy (relative, of area, mean gap and pressure) or residual; max_iterations per load; judged_in: precision of the
    certificate."""

    accuracy: float | None = None
    residual: float | None = None
    max_iterations: int = 100_000
    judged_in: type = np.float64


@dataclass(frozen=True)
class Outcome:
    """status: converged, stagnated, max_iterations, nonfinite, interrupted; errors: estimated relative errors of (area, mean gap,
    pressure); check_pairs: FFT pairs that judging took."""

    status: str
    errors: tuple[float, float, float]
    certificate: Certificate | None
    check_pairs: float


def drive(solver, target, watch=None):
    """Iterate. watch(iterations, progress), if given, is called after every step and returns a true value to stop.

    On return solver.p is the fresh pressure of the certificate, in the solver's precision.
    """
    checks = 0.0
    refreshes = 0
    demand = 1.0
    next_check = CHECK_FROM
    best, best_at = np.inf, solver.iterations
    progress = solver.progress()
    while True:
        status = None
        done = solver.iterations
        measure = _measure(progress, target)
        falling = progress.residual if measure == UNKNOWN else measure
        if falling < IMPROVEMENT * best:
            best, best_at = falling, solver.iterations
        if not progress.finite:
            status = "nonfinite"
        elif measure < demand or (progress.estimates is None and target.residual is None and done >= next_check):
            certificate = _judged(solver, progress, target)
            checks += certificate.pairs
            errors = _errors(progress, certificate, solver.N)
            if _reached(target, errors, certificate):
                return Outcome("converged", errors, certificate, checks)
            if measure < demand:
                if target.accuracy is not None and max(errors[1:]) < target.accuracy:
                    demand *= DEMAND
                refreshes += 1
                if refreshes > REFRESHES:
                    return Outcome("stagnated", errors, certificate, checks)
                solver.refresh()
            next_check = CHECK_GROWTH * done + 1
        elif done >= target.max_iterations:
            status = "max_iterations"
        elif solver.iterations - best_at > solver.patience:
            status = "stagnated"
        elif watch is not None and watch(solver.iterations, progress):
            status = "interrupted"
        if status is not None:
            certificate = _judged(solver, progress, target)
            errors = _errors(progress, certificate, solver.N)
            if status != "nonfinite" and _reached(target, errors, certificate):
                status = "converged"
            return Outcome(status, errors, certificate, checks + certificate.pairs)
        solver.step()
        progress = solver.progress()


def _judged(solver, progress, target):
    """The certificate of the solver's state; where the area is claimed to be right to the point, with the points that may be wrong."""
    near = 0.0
    if progress.estimates is not None and progress.contact > 0 and progress.estimates[0] < 1 / progress.contact:
        near = NEAR * progress.estimates[2] * solver.pressure_rms
    return certify(solver.problem_now, solver.g, solver.p, target.judged_in, near=near)


def _measure(progress, target):
    """How far from the target, by the solver's own numbers: below 1 it believes that it is there; UNKNOWN without estimates."""
    if target.residual is not None:
        return progress.residual / target.residual
    if progress.estimates is None:
        return UNKNOWN
    return max(progress.estimates) / target.accuracy


def _errors(progress, certificate, N):
    """Estimated relative errors of area, mean gap and pressure: the solver's estimates with what the certificate says."""
    if progress.estimates is None or not np.isfinite(progress.estimates).all():
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
