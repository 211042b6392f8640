"""The deflation vector (gap mode): the wave that the multilevel preconditioner M takes for far too
stiff.

Where little touches, M K takes all waves to between 0.4 and 1.6 but for one that it takes to 0.15
to 0.3, the less the larger the grid: the rise of all that is open, w = K_FF^-1 1, which answers a
change of the load (tangent.py). So M gets w as one more function,

    M + (1 - mu) w w^T/<1, w>,    mu = <1, M 1>/<1, w>: what M has of w as it is.

A w of a coarse level will do, on which theta is the share of contact: a few steps of conjugate
gradients for (K + theta) w = 1, K in units of that of the grid's shortest wave, preconditioned by
the levels from there on. Single points in contact are as soft then as on the grid.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import fft

from ..bodies.base import Body
from ..parallel.coarsening import Level
from ..parallel.grid import Grid
from .coarsest import DAMPING, CoarsestLevels


@dataclass(frozen=True)
class DeflationCalibration:
    """How well the vector is found: measured by the pairs of self-affine walls at small loads.

    Attributes
    ----------
    steps : int
        Of conjugate gradients.
    solved : float
        Relative, of <r, M r>: where contact is the same everywhere one step is enough.
    coarser, fewest, most : int
        The level has so many times fewer points than the grid, at least and at most so many.
    """

    steps: int = 3
    solved: float = 1e-6
    coarser: int = 64
    fewest: int = 250
    most: int = 128 * 128


CALIBRATION = DeflationCalibration()


class GapMode:
    """Finds the deflation vector of contacts on one grid.

    Parameters
    ----------
    grid : Grid
        The finest level.
    body : Body
        Its stiffness.
    levels : list of Level
        Those that one rank has alone.
    weights : array
        Of these, in the precision of the fields.

    Attributes
    ----------
    level : int or None
        Which of the levels w is found on; None where the grid is small.
    pairs : float
        FFT pairs of the grid that this takes.
    """

    def __init__(self, grid: Grid, body: Body, levels: Sequence[Level], weights: np.ndarray):
        points = [level.n[0] * level.n[1] for level in levels]
        self.level = next(
            (
                k
                for k, count in enumerate(points)
                if CALIBRATION.fewest
                <= count
                <= min(grid.cell_points / CALIBRATION.coarser, CALIBRATION.most)
            ),
            None,
        )
        self.pairs = 0.0
        if self.level is None:
            return
        self.pairs = CALIBRATION.steps * points[self.level] / grid.cell_points
        self.levels = CoarsestLevels(
            levels[self.level :], weights[self.level :], weights[self.level :]
        )
        n = levels[self.level].n
        q_x, q_y = (
            2 * np.pi * np.fft.fftfreq(m, size / m) * grid.a
            for m, size in zip(n, grid.sizes, strict=True)
        )
        K = body.stiffness(np.hypot(q_x[:, None], q_y[: n[1] // 2 + 1]), grid.a) / body.scale(grid)
        K[0, 0] = 0  # the rigid translation
        self.K = K.astype(weights.dtype)

    def wanted(self, share: float) -> bool:
        """Return whether there is a mode where so much of the grid is in contact."""
        return self.level is not None and 0 < share < 1

    def find(self, t: np.ndarray) -> np.ndarray:
        """Return w sqrt((1 - mu)/<1, w>) where t is the share of contact."""
        real = t.dtype.type
        w = np.zeros_like(t)
        r = np.ones_like(t)
        d = np.zeros_like(t)
        rz_before = np.inf
        M_sum = float(self.levels.apply(r, t).sum())  # <1, M 1>
        for _ in range(CALIBRATION.steps):
            z = self.levels.apply(r, t / real(DAMPING))
            rz = float((r * z).sum())
            if rz < CALIBRATION.solved * M_sum:
                break
            d = z + real(rz / rz_before) * d
            Kd = fft.irfft2(self.K * fft.rfft2(d), d.shape) + t * d
            step = real(rz / float((d * Kd).sum()))
            w += step * d
            r -= step * Kd
            rz_before = rz
        w_sum = float(w.sum())
        return w * real(np.sqrt(max(1 - M_sum / w_sum, 0.0) / w_sum))
