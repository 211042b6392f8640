"""What a solve has to reach."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import DTypeLike


@dataclass(frozen=True)
class StoppingCriterion:
    """Either accuracy (relative, of area, mean gap and pressure) or residual; max_iterations per
    load; certificate_dtype: precision of the certificate; duality: whether it has to give the
    duality gap; in_turn: whether its transforms take the memory of those of the solver, and of its
    last step; closes: whether the load is to be the least that closes the gap: a point that is
    about to open is no error of the area then, nor of the gap."""

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
