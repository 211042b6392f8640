"""What a solve has to reach."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import DTypeLike


@dataclass(frozen=True)
class StoppingCriterion:
    """Either an accuracy or a residual, and how it is certified.

    Attributes
    ----------
    accuracy : float or None
        Relative, of area, mean gap and pressure.
    residual : float or None
        rms of the pressure out of contact over the mean pressure.
    max_iterations : int
        Of one load.
    certificate_dtype : dtype
        Precision of the certificate.
    duality : bool
        Whether the certificate has to give the duality gap.
    in_turn : bool
        Whether the transforms of the certificate take the memory of those of the solver, and of its
        last step.
    closes : bool
        Whether the load is to be the least that closes the gap. A point that is about to open is
        then no error of the area, nor of the gap.
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
        """The accuracy, or else the residual."""
        return self.accuracy or self.residual or 0.0
