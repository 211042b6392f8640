"""Where single precision is enough, and where the certificate has to be in double."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ..certificate.criterion import Target
    from ..scene import Solver as Settings

# the finest accuracy that is tried in single precision; below, points too close to tell spoil the
# area
SINGLE_ACCURACY = 2e-4
FEW_POINTS = 6  # points on the wrong side that single precision may have
NOISE, NOISE_IN_TURN = (
    0.2,
    0.3,
)  # Problem.noise over what counts; in low memory double precision takes more time


def first_precision(settings: Settings) -> np.dtype:
    """The precision that a sweep begins with; settings: scene.Solver."""
    if settings.precision != "auto":
        return np.dtype({"single": np.float32, "double": np.float64}[settings.precision])
    loose = settings.accuracy is not None and settings.accuracy >= SINGLE_ACCURACY
    return np.dtype(np.float32 if loose else np.float64)


def few_points(N: int, p_star: float, accuracy: float | None) -> bool:
    """Whether so few of N points will touch that single precision, which may err in a few of them,
    cannot give the area to an accuracy (None where a residual is asked for)."""
    expected = N * min(1.0, 2 * p_star)  # a_r is about 2 p*
    return accuracy is not None and FEW_POINTS / expected > accuracy


def counting(asked: Target | Settings, p_star: float) -> float:
    """Errors of the pressure at all open points, in the problem's unit, that count as much as what
    is asked for."""
    return asked.residual * p_star if asked.residual else (asked.accuracy or 0.0) * p_star**0.5
