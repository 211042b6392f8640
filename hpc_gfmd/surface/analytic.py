"""Surfaces given by a formula."""

from collections.abc import Callable
from typing import Any

import numpy as np


def wave_rows(spec: Any, n: tuple[int, int]) -> Callable[[int, int], np.ndarray]:
    """z = A cos(2 pi k_x x/L_x) cos(2 pi k_y y/L_y); returns a function of global rows (start,
    stop)."""
    k_x, k_y = spec.periods
    y = _cosine(k_y, n[1])

    def rows(start: int, stop: int) -> np.ndarray:
        return spec.amplitude * np.outer(_cosine(k_x, n[0])[start:stop], y)

    return rows


def _cosine(k: int, n: int) -> np.ndarray:
    # k i mod n first: the argument is then exact, and the samples have the symmetry of the wave.
    return np.cos(2 * np.pi * ((k * np.arange(n)) % n) / n)


def sphere_rows(spec: Any, n: tuple[int, int]) -> Callable[[int, int], np.ndarray]:
    """z = -r^2/(2 R) about the centre of the cell; returns a function of global rows (start,
    stop)."""
    L_x, L_y = spec.physical_sizes
    x = (np.arange(n[0]) - n[0] // 2) * (L_x / n[0])
    y = (np.arange(n[1]) - n[1] // 2) * (L_y / n[1])

    def rows(start: int, stop: int) -> np.ndarray:
        return -(x[start:stop, None] ** 2 + y[None] ** 2) / (2 * spec.radius)

    return rows
