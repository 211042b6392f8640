"""Which change of pressure takes each point to the other side, into contact or out of it.

The contact grows with the load, point by point. So an area of k points belongs to the load at which
the k-th smallest of these pressures is 0. It is a continuous function of the load, unlike the
number of points.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ..solvers.base import Solver

BINS = 1024  # intervals of the histogram that one pass over all points makes


class SideChanges:
    """The change-of-side pressures of all points of a state, ranked from the smallest.

    That of a point in contact is minus its pressure (below 0); that of an open point is the
    pressure at this point alone that would close its gap (above 0). So the n points in contact
    have ranks 1 to n. Nothing is sorted or stored: each rank is found by passes over all points.

    Parameters
    ----------
    solver : Solver
        Its present gap and pressure are used, without a copy. Creation is collective.
    resolution : float
        Accuracy of the values, in the program's unit of pressure.

    Attributes
    ----------
    least, most : float
        The smallest and the largest value over all ranks.
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
        """Return the value of a rank, from 1 (smallest) to the number of points. Collective."""
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
        """Return the values of the points of the surface in local rows i0 <= i < i1."""
        g = self.g[i0:i1, : self._points].astype(np.float64)
        p = self.p[i0:i1, : self._points].astype(np.float64)
        return np.where(g > 0, g / self.compliance, -p)

    def _extremes(self, i0: int, i1: int) -> tuple[float, float]:
        """Return the smallest and the largest value of local rows; (inf, -inf) without points."""
        values = self._values(i0, i1)
        return float(values.min(initial=np.inf)), float(values.max(initial=-np.inf))

    def _counts(self, low: float, width: float) -> np.ndarray:
        """Return a histogram (BINS + 2,) of the values of all MPI ranks: up to `low`, in BINS
        intervals of this width above it, and the rest. Collective."""

        def count(i0: int, i1: int) -> np.ndarray:
            bins = np.ceil((self._values(i0, i1) - low) / width)
            bins = np.clip(bins, 0, BINS + 1).astype(np.int64)
            return np.bincount(bins.ravel(), minlength=BINS + 2)

        rows, _ = self.grid.inside
        counts = [np.zeros(BINS + 2), *self.grid.by_rows(count, rows)]
        return self.grid.comm.sum(np.sum(counts, axis=0))
