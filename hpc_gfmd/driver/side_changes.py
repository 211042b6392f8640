"""How far points are from a change of sides, into contact or out of it, ranked over all points.

The contact grows with the load, point by point. So the load that gives an area of k points is where
the k-th point, in the order of this distance, just touches: a continuous function of the load with
one zero, unlike the number of points.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ..solvers.base import Solver

BINS = 1024  # of one pass over all points


class SideChanges:
    """The pressures that take points of a state to the other side, in increasing order.

    That of a point in contact is minus its pressure; that of an open point is the pressure which
    closes its gap by itself. The first n are those of the n points in contact, below 0.

    Parameters
    ----------
    solver : Solver
        Its gap and pressure, local slabs.
    resolution : float
        To which values are told apart, in the program's unit of pressure.
    """

    def __init__(self, solver: Solver, resolution: float):
        self.grid = solver.grid
        self.g = solver.g
        self.p = solver.p
        self.resolution = resolution
        self.compliance = 1.0 / solver.problem.body.scale(solver.grid)
        rows, self._points = self.grid.inside
        extremes = [(np.inf, -np.inf), *self.grid.by_rows(self._extremes, rows)]
        lowest, highest = np.transpose(extremes)
        self.least = float(self.grid.comm.min([lowest.min()])[0])
        self.most = float(self.grid.comm.max([highest.max()])[0])

    def of_rank(self, rank: int) -> float:
        """Return the rank-th smallest value, from 1 to the number of points. Collective."""
        low, high = self.least, self.most
        while high - low > max(self.resolution, np.spacing(max(abs(low), abs(high)))):
            width = (high - low) / BINS
            up_to = np.cumsum(self._counts(low, width))  # values up to low, low + width, ...
            k = int(np.searchsorted(up_to, rank))
            if k == 0:
                return low
            if k > BINS:
                return high
            low, high = low + (k - 1) * width, low + k * width
        return 0.5 * (low + high)

    def _values(self, i0: int, i1: int) -> np.ndarray:
        g = self.g[i0:i1, : self._points].astype(np.float64)
        p = self.p[i0:i1, : self._points].astype(np.float64)
        return np.where(g > 0, g / self.compliance, -p)

    def _extremes(self, i0: int, i1: int) -> tuple[float, float]:
        values = self._values(i0, i1)
        return float(values.min(initial=np.inf)), float(values.max(initial=-np.inf))

    def _counts(self, low: float, width: float) -> np.ndarray:
        """Count the values up to low, in the BINS intervals from there on, and above, of all
        ranks."""

        def count(i0: int, i1: int) -> np.ndarray:
            bins = np.ceil((self._values(i0, i1) - low) / width)
            bins = np.clip(bins, 0, BINS + 1).astype(np.int64)
            return np.bincount(bins.ravel(), minlength=BINS + 2)

        rows, _ = self.grid.inside
        counts = [np.zeros(BINS + 2), *self.grid.by_rows(count, rows)]
        return self.grid.comm.sum(np.sum(counts, axis=0))
