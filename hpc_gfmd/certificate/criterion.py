"""The accuracy that the solution of a load has to reach, and how far a state is from it."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, isnan, nan
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .certificate import Certificate
    from .error_estimates import Estimate


@dataclass(frozen=True)
class StoppingCriterion:
    """When a load counts as solved: at an accuracy or at a residual."""

    # largest relative error of area, mean gap and pressure; None with residual
    accuracy: float | None = None
    # largest rms pressure out of contact, over the mean; None with accuracy
    residual: float | None = None
    max_iterations: int = 100_000  # of one load
    # accuracy of the result, where later loads need a better one of gap and pressure; or None
    of_result: float | None = None

    @property
    def tolerance(self) -> float:
        """The accuracy if there is one, else the residual; 0 without both."""
        return self.accuracy or self.residual or 0.0

    @property
    def largest_error(self) -> float:
        """Largest error relative to a value found: the true one may be smaller by as much."""
        return self.tolerance / (1 + self.tolerance)

    @property
    def largest_of_result(self) -> float:
        """The same of the result: of its area, and of errors that iterations cannot reduce."""
        tolerance = self.of_result or self.tolerance
        return tolerance / (1 + tolerance)

    def measure(self, residual: float, estimate: Estimate | None) -> float:
        """Return the residual, or error that a solver estimates, over the requested one: below 1 it
        expects to be done, apart from the area; infinite without the errors.
        """
        if self.residual is not None:
            return residual / self.residual
        if estimate is None:
            return inf
        errors = (0.0, min(estimate.gap, 1.0), estimate.pressure)
        return self._largest(errors, estimate.attainable)

    def left(self, certificate: Certificate) -> float:
        """Return the certified residual or error over the requested one, without those limited by
        rounding; infinite if not finite or not stable.
        """
        if not certificate.finite or certificate.stability <= 0:
            return inf
        if self.residual is not None:
            return certificate.residual / self.residual
        left = self._largest(certificate.errors, certificate.attainable)
        return inf if isnan(left) else left

    def _largest(
        self, errors: tuple[float, float, float], attainable: tuple[float, float]
    ) -> float:
        """Return the largest error over the requested one, but for those limited by rounding."""
        area, *gap_and_pressure = errors
        errors_left = [
            error / self.largest_error
            for error, best in zip(gap_and_pressure, attainable, strict=True)
            if not best >= self.largest_error  # a limit that is nan is none
        ]
        errors_left.append(area / self.largest_of_result)
        return nan if any(isnan(error) for error in errors_left) else max(errors_left)

    def status(self, certificate: Certificate) -> str:
        """Return "converged", or "stagnated" if an error that iterations cannot reduce is large."""
        met = self.residual is not None or all(
            error < self.largest_of_result for error in certificate.errors
        )
        return "converged" if met else "stagnated"
