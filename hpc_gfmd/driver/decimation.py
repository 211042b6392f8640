"""A grid and the coarse grid of every second point, between which nested iteration goes.

Decimation keeps the heights of the asperities; averages and envelopes do not, and start worse at
small loads. Coarse grids live on fewer and fewer ranks; the others wait.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..kernels.prolong import HALO
from ..parallel.coarsening import agglomerated, halved
from ..parallel.grid import Grid
from ..parallel.halo import neighbours, rows_of
from ..parallel.threads import threads_for

if TYPE_CHECKING:
    from ..operators.problem import Problem

SLIM = 4  # an axis with fewer points is not decimated: cubic interpolation takes 4
COARSEST = 32  # smallest number of points along an axis (geometric mean of both)
# Smallest number of points per rank: fewer are solved faster than sent (scripts/bench scaling).
RANK_POINTS = 2**13


@dataclass(frozen=True)
class Decimation:
    """A grid and the coarse grid of every second point; transfers fields between the two."""

    fine: Grid
    coarse: Grid | None  # None on ranks that own none of its rows
    n: tuple[int, int]  # points of the coarse grid along each axis
    nominal: tuple[int, int]  # how many of them are on the surface
    beside: np.ndarray  # first coarse row within the fine rows of every rank; at the end n[0]
    starts: np.ndarray  # first coarse row that every rank owns; at the end n[0]

    @classmethod
    def of(cls, grid: Grid) -> Decimation | None:
        """Return the decimation of a grid, None if it is too coarse for one. Collective."""
        n, _ = halved(grid.n, grid.spacings, SLIM)
        coarsened = [a != b for a, b in zip(n, grid.n)]
        points = [k for k, c in zip(n, coarsened) if c]
        if not points or np.prod(points) < COARSEST ** len(points):
            return None
        beside = (grid.starts + 1) // 2 if coarsened[0] else grid.starts
        n_x, n_y = ((k + 1) // 2 if c else k for k, c in zip(grid.nominal, coarsened))
        starts = agglomerated(beside, n[0] * n[1], RANK_POINTS)
        ranks = np.flatnonzero(np.diff(starts)).tolist()
        comm = grid.comm.subcomm(ranks)
        starts_of_part = np.append(starts[ranks], n[0])
        threads = threads_for(n[0] * n[1] // len(ranks), grid.threads)
        coarse = None
        if comm is not None:
            coarse = Grid.kept(n, grid.sizes, comm, threads, starts_of_part, (n_x, n_y))
        return cls(grid, coarse, n, (n_x, n_y), beside, starts)

    @property
    def steps(self) -> list[int]:
        """Fine points per coarse point along x and y, each 1 or 2."""
        return [2 if a != b else 1 for a, b in zip(self.n, self.fine.n, strict=True)]

    def problem(self, problem: Problem) -> Problem | None:
        """Return the problem on the coarse grid, None on ranks without rows: heights are divided by
        the ratio of the spacings, pressures stay. Collective.
        """
        step = self.steps
        h = problem.heights[(-self.fine.rows[0]) % step[0] :: step[0], :: step[1]]
        beside, starts = (np.minimum(rows, self.nominal[0]) for rows in (self.beside, self.starts))
        if not np.array_equal(beside, starts):
            h = rows_of(self.fine.comm, h, beside, starts[:-1], starts[1:])
        if self.coarse is None:
            return None
        scale = h.dtype.type(self.coarse.a / self.fine.a)
        heights = np.empty(h.shape, h.dtype)

        def divide(i0: int, i1: int) -> None:
            np.divide(h[i0:i1], scale, out=heights[i0:i1])

        self.coarse.by_rows(divide, len(h))
        return replace(problem, grid=self.coarse, h=heights, height_error=0.0)

    def around(self, a: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the coarse rows that this rank's fine rows need: HALO before, `beside`, HALO
        after. Collective. a: own rows, perhaps none.
        """
        comm = self.fine.comm
        if np.array_equal(self.beside, self.starts):
            before, after = neighbours(comm, a, self.starts, HALO)
            return before, a, after
        rows = rows_of(comm, a, self.starts, self.beside[:-1] - HALO, self.beside[1:] + HALO)
        return rows[:HALO], rows[HALO:-HALO], rows[-HALO:]
