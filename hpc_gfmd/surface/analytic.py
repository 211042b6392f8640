"""Surfaces given by a formula."""

from typing import Any

import numpy as np

from .heights import Rows


def wave_rows(spec: Any) -> Rows:
    """Return (start, stop) -> rows of z = A cos(2 pi k_x x/L_x) cos(2 pi k_y y/L_y)."""
    # k i mod n first: the argument is then exact, and the samples have the symmetry of the wave.
    x, y = (np.cos(2 * np.pi * ((k * np.arange(n)) % n) / n) for k, n in zip(spec.periods, spec.n))
    return lambda start, stop: spec.amplitude * np.outer(x[start:stop], y)


def flat_rows(start: int, stop: int) -> np.ndarray:
    """Return rows of z = 0, shape (stop - start, 1), which broadcast against a form."""
    return np.zeros((stop - start, 1))
