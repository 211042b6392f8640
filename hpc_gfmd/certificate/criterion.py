"""The accuracy that the solution of a load has to reach."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import DTypeLike


@dataclass(frozen=True)
class StoppingCriterion:
    """When a load counts as solved: at an accuracy or at a residual; and how to certify it."""

    # largest relative error of area, mean gap and pressure; None with residual
    accuracy: float | None = None
    # largest rms pressure out of contact, over the mean; None with accuracy
    residual: float | None = None
    max_iterations: int = 100_000  # of one load
    certificate_dtype: DTypeLike = np.float64
    duality: bool = False
    in_turn: bool = False  # the solver frees transforms and last step meanwhile
    # The smallest load that closes the gap is sought: points that are about to open then do not
    # count as errors of area and gap.
    closes: bool = False
    # accuracy of the result, where later loads need a better one of gap and pressure; or None
    of_result: float | None = None

    @property
    def tolerance(self) -> float:
        """The accuracy if there is one, else the residual; 0 without both."""
        return self.accuracy or self.residual or 0.0

    @property
    def largest_error(self) -> float:
        """Largest allowed error relative to a value found: the true value may be smaller by as
        much, and this is the tolerance of it."""
        return self.tolerance / (1 + self.tolerance)

    @property
    def largest_of_result(self) -> float:
        """The same of the result: of its area, and of errors that iterations cannot reduce."""
        tolerance = self.of_result or self.tolerance
        return tolerance / (1 + tolerance)
