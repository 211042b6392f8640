"""Surfaces given by a formula, and forms under others."""

from collections.abc import Callable
from math import inf
from typing import Any

import numpy as np

Rows = Callable[[int, int], np.ndarray]  # (start, stop) -> heights, float64 (stop - start, n_y)


def wave_rows(spec: Any) -> Rows:
    """Return the rows of z = A cos(2 pi k_x x/L_x) cos(2 pi k_y y/L_y)."""
    x, y = (_cosine(k, n) for k, n in zip(spec.periods, spec.n))
    return lambda start, stop: spec.amplitude * np.outer(x[start:stop], y)


def _cosine(k: int, n: int) -> np.ndarray:
    # k i mod n first: the argument is then exact, and the samples have the symmetry of the wave.
    return np.cos(2 * np.pi * ((k * np.arange(n)) % n) / n)


def on_form(
    rows: Rows, radii: tuple[float, float], n: tuple[int, ...], sizes: tuple[float, ...]
) -> Rows:
    """Put heights on the form z = -x^2/(2 R_x) - y^2/(2 R_y) about the centre of the cell; where
    both radii are inf they stay as they are."""
    R = min(radii)
    if R == inf:
        return rows
    x, y = (
        ((np.arange(k) - k // 2) * (size / k)) ** 2 * (R / radius)
        for k, size, radius in zip(n, sizes, radii)
    )
    return lambda start, stop: rows(start, stop) - (x[start:stop, None] + y) / (2 * R)


def flat_rows(start: int, stop: int) -> np.ndarray:
    """Return rows of z = 0."""
    return np.zeros((stop - start, 1))
