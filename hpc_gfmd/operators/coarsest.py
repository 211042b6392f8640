"""The coarse levels of the preconditioner that one rank sweeps alone, in one call."""

from collections.abc import Sequence

import numpy as np

from ..kernels.multilevel import sweep_coarsest
from ..parallel.coarsening import Level

DAMPING = 4.0  # of a level by the contact on it, over its stiffness


class CoarsestLevels:
    """levels: finest first, with their weights and softness, see hierarchy.py.

    mode, at: a field that M has as one more function, flat, empty where there is none, and the
    level that it is on; r, t: z and the contact of the last sweep on all levels, flat, which begin
    at `offsets`.
    """

    def __init__(self, levels: Sequence[Level], weights: np.ndarray, softness: np.ndarray):
        dtype = weights.dtype
        self.shapes = np.array([level.n for level in levels], np.int64).reshape(-1, 2)
        sizes = self.shapes[:, 0] * self.shapes[:, 1]
        self.offsets = np.concatenate([[0], np.cumsum(sizes)[:-1]]).astype(np.int64)
        self.weights, self.softness = weights, softness
        self.r, self.t = np.zeros(sizes.sum(), dtype), np.zeros(sizes.sum(), dtype)
        self.damping = dtype.type(DAMPING)
        self.mode, self.at = np.zeros(0, dtype), 0

    def sweep(self, r: np.ndarray, t: np.ndarray) -> tuple[np.ndarray, list[float], float]:
        """Return z on the first level from r and t there; the sums over levels of softness times
        <r, r>, <t, t> and <r, t>, as sums over the points of the first; the mean of r."""
        n = r.size
        self.r[:n] = r.ravel()
        self.t[:n] = t.ravel()
        *squares, mean = sweep_coarsest(
            self.r,
            self.t,
            self.shapes,
            self.offsets,
            self.weights,
            self.softness,
            self.damping,
            self.mode,
            self.at,
        )
        return self.r[:n].reshape(r.shape), squares, mean

    def contact(self, k: int) -> np.ndarray:
        """Return t of level k in the last sweep."""
        n = self.shapes[k]
        return self.t[self.offsets[k] : self.offsets[k] + n[0] * n[1]].reshape(n)
