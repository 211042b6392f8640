"""The accuracy that the solution of a load has to reach."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import DTypeLike


@dataclass(frozen=True)
class StoppingCriterion:
    """When a load counts as solved: at an accuracy or at a residual; and how to certify it.

    Attributes
    ----------
    accuracy : float or None
        Largest relative error of area, mean gap and pressure field; None if `residual` is given.
    residual : float or None
        Largest rms pressure out of contact, over the mean pressure; None if `accuracy` is given.
    max_iterations : int
        Largest number of iterations of one load.
    certificate_dtype : dtype
        Precision of the certificate.
    duality : bool
        Whether the certificate computes the duality gap.
    in_turn : bool
        Whether the solver frees its transforms and its last step while a certificate is computed.
    closes : bool
        Whether the smallest load that closes the gap is sought. Points that are about to open then
        do not count as errors of area and gap.
    """

    accuracy: float | None = None
    residual: float | None = None
    max_iterations: int = 100_000
    certificate_dtype: DTypeLike = np.float64
    duality: bool = False
    in_turn: bool = False
    closes: bool = False

    @property
    def tolerance(self) -> float:
        """The accuracy if there is one, else the residual; 0 without both."""
        return self.accuracy or self.residual or 0.0
