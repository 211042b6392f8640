"""The errors that loads leave behind: the heights for the next load are not exact.

The error of a load's pressure is K times that of its displacement, and so of the dents and the
relaxation that it leaves. It is the height error of the next problem, fades as the body forgets,
and counts in the certificate like rounding: iterations cannot reduce it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import hypot, isfinite, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np

from .memory import Maxwell

if TYPE_CHECKING:
    from ..certificate.certificate import Certificate
    from .memory import Element


class InheritedError:
    """Makes `Problem.height_error` from earlier certificates, the same on all ranks. Errors of
    displacements fade as the body forgets, dents keep the largest; independent, so squares are
    added.
    """

    def __init__(self, elements: Sequence[Element], keeps_dents: bool):
        self.keeps_dents = keeps_dents
        self.of_dents = 0.0
        self.of_gap = 0.0  # largest error of the mean gap, a length
        self.body = Maxwell(elements, np.zeros(0))  # a number for each load

    def before(self, dt: float) -> float:
        """Return the error of the heights in a step of dt."""
        of_loads, _ = self.body.before(dt)
        return hypot(float(np.linalg.norm(of_loads)), self.of_dents)

    def after(self, dt: float, certificate: Certificate) -> bool:
        """Remember a load's errors after a step of dt; return whether they are known."""
        inherited = self.before(dt)
        _, gap, pressure = certificate.errors
        loaded = certificate.contact > 0
        error = pressure * certificate.pressures if loaded else inherited
        if not (isfinite(error) and isfinite(gap)):
            return False
        self.of_gap = max(self.of_gap, gap * certificate.gap_mean)
        if self.keeps_dents:
            own = sqrt(max(error**2 - inherited**2, 0.0))
            self.of_dents = max(self.of_dents, own)
        if self.body.elements:
            body = self.body
            body.u, *body.q = (np.append(x, 0.0) for x in (body.u, *body.q))
            body.after(dt, np.append(np.zeros(len(body.u) - 1), error))
        return True

    def numbers(self) -> dict[str, Any]:
        """Return all that is remembered, to be stored."""
        return {
            "error_of_dents": self.of_dents,
            "error_of_gap": self.of_gap,
            "errors_of_loads": np.concatenate([self.body.u, *self.body.q]).tolist(),
        }

    def restore(self, numbers: Mapping[str, Any]) -> None:
        """Take up stored `numbers`."""
        self.of_dents, self.of_gap = numbers["error_of_dents"], numbers["error_of_gap"]
        of_loads = np.array(numbers["errors_of_loads"], float)
        self.body.u, *self.body.q = of_loads.reshape(1 + len(self.body.elements), -1)
