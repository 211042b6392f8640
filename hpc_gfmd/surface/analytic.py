"""Surfaces given by a formula."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

ROWS = 64  # of heights that are read at a time
Rows = Callable[[int, int], np.ndarray]  # (start, stop) -> heights, float64 (stop - start, n_y)


@dataclass(frozen=True)
class StoredRows:
    """The rows of heights `z` in memory, of which the first is row `begin` of the map."""

    z: np.ndarray
    begin: int = 0

    def __call__(self, start: int, stop: int) -> np.ndarray:
        """Return rows start <= i < stop, a view if they are in double precision."""
        return np.asarray(self.z[start - self.begin : stop - self.begin], np.float64)


def collected(rows: Rows, start: int, stop: int, width: int) -> np.ndarray:
    """Return rows start <= i < stop of `width` heights, read a few at a time; those in memory in
    double precision as they are, which must not be changed.
    """
    if isinstance(rows, StoredRows) and rows.z.dtype == np.float64:
        return rows(start, stop)
    z = np.empty((stop - start, width))
    for i in range(start, stop, ROWS):
        z[i - start : i - start + ROWS] = rows(i, min(i + ROWS, stop))
    return z


def wave_rows(spec: Any) -> Rows:
    """Return (start, stop) -> rows of z = A cos(2 pi k_x x/L_x) cos(2 pi k_y y/L_y)."""
    # k i mod n first: the argument is then exact, and the samples have the symmetry of the wave.
    x, y = (np.cos(2 * np.pi * ((k * np.arange(n)) % n) / n) for k, n in zip(spec.periods, spec.n))
    return lambda start, stop: spec.amplitude * np.outer(x[start:stop], y)


def flat_rows(start: int, stop: int) -> np.ndarray:
    """Return rows of z = 0, shape (stop - start, 1), which broadcast against a form."""
    return np.zeros((stop - start, 1))
