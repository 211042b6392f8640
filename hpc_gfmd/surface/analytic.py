"""Surfaces given by a formula."""

from collections.abc import Callable
from typing import Any

import numpy as np

Rows = Callable[[int, int], np.ndarray]  # (start, stop) -> heights, float64 (stop - start, n_y)


def wave_rows(spec: Any) -> Rows:
    """Return a function (start, stop) -> rows of z = A cos(2 pi k_x x/L_x) cos(2 pi k_y y/L_y).

    spec: a scene's [surface] of kind "wave", of which n, periods (k_x, k_y) and amplitude are used.
    """
    # k i mod n first: the argument is then exact, and the samples have the symmetry of the wave.
    x, y = (np.cos(2 * np.pi * ((k * np.arange(n)) % n) / n) for k, n in zip(spec.periods, spec.n))
    return lambda start, stop: spec.amplitude * np.outer(x[start:stop], y)


def flat_rows(start: int, stop: int) -> np.ndarray:
    """Return rows of the flat surface z = 0, with a single point along y for any number of points.

    They are broadcast against what is added to them (`Topography.on_form`).

    Parameters
    ----------
    start, stop : int
        The rows start <= i < stop.

    Returns
    -------
    ndarray, shape (stop - start, 1)
    """
    return np.zeros((stop - start, 1))
