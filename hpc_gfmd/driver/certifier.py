"""How the states of a load are certified (certificate/certificate.py): in which precision, and with
which memory.
"""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..certificate.certificate import certify

if TYPE_CHECKING:
    import numpy as np

    from ..certificate.certificate import Certificate
    from ..solvers.base import Solver


@dataclass(frozen=True)
class Certifier:
    """Certifies the states of a solver."""

    dtype: np.dtype  # of its transforms
    duality: bool = False  # whether certificates have the duality gap, for half an FFT pair more
    in_turn: bool = False  # whether the solver frees transforms and last step during a certificate

    def certify(self, solver: Solver) -> Certificate:
        """Certify the solver's state (operators/state.py: what changes and follows). Collective."""
        with solver.room() if self.in_turn else nullcontext():
            certificate = certify(
                solver.problem_now, solver.state, solver.levels, self.dtype, self.duality
            )
            if self.in_turn:
                solver.grid.forget_fft(self.dtype)
        return certificate
