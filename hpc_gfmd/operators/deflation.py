"""The deflation vector (gap mode): the wave for which the multilevel preconditioner M is too stiff,
equation (6) in docs/method.md.

If little of the surface touches, the eigenvalues of M K lie between 0.4 and 1.6, except for one of
0.15 to 0.3, which is the smaller the larger the grid. Its wave is the response of all open points
to a change of the load, w = K_FF^-1 1 (tangent.py). So w is added to M,

    M + (1 - mu) w w^T/<1, w>,    mu = <1, M 1>/<1, w>,

where mu is the share of w w^T/<1, w> that M contains without this. A w of a coarse level is good
enough: it takes a few steps of conjugate gradients for (K + theta) w = 1, with theta the share of
contact at each point of that level and K in units of that of the grid's shortest wave. Single
points in contact are as soft then as on the grid.
"""

from collections.abc import Sequence

import numpy as np

from ..bodies.base import Body, Multipliers
from ..parallel.coarsening import Level
from ..parallel.fft import SlabFFT
from ..parallel.grid import Grid
from ..parallel.wisdom import planned
from .coarsest import DAMPING, CoarsestLevels, LevelTables
from .elastic import reader

# Chosen by FFT pairs at small loads: they cost or save pairs only.
STEPS = 3  # of conjugate gradients at most
# The steps end once <r, M r> is below this, relative to its first value: one step is enough where
# contact is the same everywhere.
SOLVED = 1e-6
COARSER = 64  # the level has at least so many times fewer points than the grid
FEWEST = 250  # number of points of the level, at least
MOST = 128 * 128  # number of points of the level, at most


def level_of_mode(levels: Sequence[Level]) -> int | None:
    """Return the number of the finest level (>= 1) of FEWEST to MOST points, or None."""
    points = [level.n[0] * level.n[1] for level in levels]
    most = min(points[0] / COARSER, MOST)
    return next((k for k, count in enumerate(points) if FEWEST <= count <= most), None)


class GapMode:
    """Computes deflation vectors. `level`: where, None if the grid is too small; `pairs`: FFT pairs
    of a `find`; `levels`: M from there on, and `fft`, missing without one.
    """

    def __init__(self, grid: Grid, body: Body, levels: Sequence[Level], weights: np.ndarray):
        self.level = level_of_mode(levels)
        self.pairs = 0.0
        if self.level is None:
            return
        n = levels[self.level].n
        self.pairs = STEPS * n[0] * n[1] / grid.cell_points
        coarser = slice(self.level, None)
        self.levels = CoarsestLevels(
            LevelTables(levels[coarser], weights[coarser], weights[coarser])
        )
        level_grid = Grid(n, grid.sizes)
        self.fft = planned(
            grid.comm, weights.dtype, lambda: level_grid.fft(weights.dtype), ("gap mode", n)
        )
        self._factors = _stiffness_of_level(grid, body, level_grid, self.fft)

    def wanted(self, share: float) -> bool:
        """Return whether the grid is large enough for a mode and 0 < share < 1 of it in contact."""
        return self.level is not None and 0 < share < 1

    def find(self, t: np.ndarray) -> np.ndarray:
        """Return w sqrt((1 - mu)/<1, w>), to be added to M as an outer product; t: share of contact
        on `level`, overwritten. Not collective.
        """
        real = t.dtype.type
        theta = t / real(DAMPING)
        w = np.zeros_like(t)
        r = np.ones_like(t)
        d = np.zeros_like(t)
        Kd = np.empty_like(t)
        rz_before = np.inf
        M_sum = float(self.levels.apply(r, t).sum())  # <1, M 1>
        for _ in range(STEPS):
            z = self.levels.apply(r, theta)
            rz = float((r * z).sum())
            if rz < SOLVED * M_sum:
                break
            d = z + real(rz / rz_before) * d
            self._multiply(d, Kd)
            Kd += t * d
            step = real(rz / float((d * Kd).sum()))
            w += step * d
            r -= step * Kd
            rz_before = rz
        w_sum = float(w.sum())
        return w * real(np.sqrt(max(1 - M_sum / w_sum, 0.0) / w_sum))

    def _multiply(self, d: np.ndarray, Kd: np.ndarray) -> None:
        """Set Kd to K d, over the stiffness of the grid's shortest wave; both on `level`."""

        def use(i0: int, i1: int, x: np.ndarray) -> None:
            Kd[i0:i1] = x[: i1 - i0]

        self.fft.forward_rows(reader(d))
        self.fft.multiply_columns(self._factors, inverse=False, backward=True)
        self.fft.backward_rows(use)


def _stiffness_of_level(grid: Grid, body: Body, level_grid: Grid, fft: SlabFFT) -> tuple:
    """Return the `factors` of SlabFFT.multiply_columns for K on a level, over the shortest wave's,
    0 for the translation; grid: the finest level, the unit of K.
    """
    to_unit = grid.a / level_grid.a
    q_x = level_grid.q_x * to_unit
    q_y = level_grid.column_tables(fft)[0] * to_unit
    K = body.stiffness(np.hypot(q_x[: len(q_x) // 2 + 1], q_y[..., None]), grid.a)
    K[0, 0, 0] = 0
    table = (K / body.scale(grid)).astype(fft.dtype)
    return Multipliers(level_grid, fft, (q_x, q_y), table).factors
