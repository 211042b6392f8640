"""Nested iteration (cascadic multigrid): solve decimated grids roughly first, and interpolate;
"Nested iteration" in docs/method.md.

The displacement is then corrected for the finer grid's own heights without an FFT
(kernels/prolong.py), which saves one or two iterations.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import DTypeLike

from ..kernels.prolong import SWEEPS, gradient_steps, prolong_gap
from ..parallel import interrupt
from ..parallel.grid import Grid
from ..parallel.halo import neighbours
from ..parallel.threads import on_threads
from .box import Box, Rectangle
from .decimation import Decimation
from .grid_errors import CoarseContact, coarser_contacts

if TYPE_CHECKING:
    from ..operators.problem import Problem
    from ..solvers.base import Solver
    from .target import Target

    MakeSolver = Callable[[Problem], Solver]

# Factor by which the residual is reduced on a coarse grid, once for each finer grid. More would be
# of no use, because each finer grid adds about as much residual again. Measured by FFT pairs and
# time of self-affine walls; without effect on the accuracy of the solution.
REDUCTION = 0.6
MOST_ITERATIONS = 60  # on a coarse grid


def cold_gap(problem: Problem) -> np.ndarray:
    """Return the gap of a rigid plane pressed down to mean + rms height, 0 where it is cut off.
    Collective. Needs stored heights.
    """
    h = problem.heights
    if problem.p0 >= problem.body.full_p_star:
        return np.zeros(problem.grid.shape, h.dtype)
    N = problem.grid.N
    total, squares = problem.grid.comm.sum(
        [h.sum(dtype=np.float64), np.einsum("ij,ij->", h, h, dtype=np.dtype(np.float64))]
    )
    mean = total / N
    rms = np.sqrt(max(squares / N - mean * mean, 0.0))
    level = h.dtype.type(max(mean - rms, 0.0))
    rows, points = problem.grid.inside
    g = np.empty(problem.grid.shape, h.dtype)
    g[rows:] = -level
    g[:rows, points:] = -level
    np.maximum(h - level, 0, out=g[:rows, :points])
    return g


def undeformed_gap(problem: Problem) -> np.ndarray:
    """Return the gap of the undeformed body: h on the surface, which must be stored, 0 beyond."""
    h = problem.heights
    rows, points = problem.grid.inside
    g = np.zeros(problem.grid.shape, h.dtype)
    g[:rows, :points] = h
    return g


class Candidate(NamedTuple):
    """A gap (local slab) to start from, or a box to solve the contact in."""

    gap: np.ndarray | None  # local slab; None with a box
    pairs: float = 0.0  # FFT pairs that it took, converted to pairs of the grid
    # the contacts on all coarser grids, finest first; with a box all but the first
    coarser: Sequence[CoarseContact] = ()
    # where all points that can touch are, if asked for and the contact is light
    box: Box | None = None
    may_be_solved: bool = False  # whether the gap may be the solution


class Nested:
    """All coarser grids of a grid, with their transforms. Collective.

    finer: how many finer grids there are. `step`: to the next coarser grid, None on the coarsest;
    `coarser`: the Nested of that grid, None on ranks without rows of it; `reduction`: factor by
    which the residual is reduced on it.
    """

    def __init__(self, grid: Grid, dtype: DTypeLike, finer: int = 0):
        self.grid = grid
        self.step = Decimation.of(grid)
        self.coarser: Nested | None = None
        self.reduction = REDUCTION ** (finer + 1)
        if self.step is not None and self.step.coarse is not None:
            self.step.coarse.fft(dtype)
            self.coarser = Nested(self.step.coarse, dtype, finer + 1)

    @property
    def grids(self) -> list[Grid]:
        """The coarser grids of which this rank owns rows, finest first."""
        return [self.coarser.grid, *self.coarser.grids] if self.coarser is not None else []

    def candidate(
        self,
        problem: Problem,
        make_solver: MakeSolver,
        target: Target,
        into: np.ndarray | None = None,
        in_box: bool = False,
    ) -> Candidate:
        """Solve roughly on coarser grids, from `cold_gap` on the coarsest, and interpolate.
        Collective.

        `target` has or finds, and changes, p0 on every grid. `into` gets the gap, perhaps that of
        problem.h. in_box: where a box holds all points that touch in the start on the next coarser
        grid, return that, and solve nothing more. Stopped is raised on all ranks.
        """
        if self.step is None:
            g = cold_gap(problem)
            if into is not None:
                into[...] = g
            return Candidate(g if into is None else into)
        comm = problem.grid.comm
        coarse = self.step.problem(problem)
        solver = None
        with interrupt.shared(comm, (None, False, 0.0, ())) as solved:
            if coarse is not None and self.coarser is not None:
                start = self.coarser.candidate(coarse, make_solver, target)
                assert start.gap is not None  # no box was asked for there
                looks = in_box and start.coarser
                box = self._box_by(coarse, start.gap, self.step.steps) if looks else None
                coarse = replace(coarse, p0=target.begin(coarse))
                pairs = start.pairs
                full = False
                scale = coarse.grid.a / problem.grid.a
                if box is not None:
                    coarser = [c._replace(gap_mean=c.gap_mean * scale) for c in start.coarser]
                else:
                    solver = roughly_solved(coarse, make_solver, start.gap, self.reduction, target)
                    pairs += solver.pairs
                    contact = solver.progress(with_errors=False).contact
                    full = not coarse.grid.padded and contact == coarse.grid.N
                    coarser = coarser_contacts(solver, start.coarser, scale)
                pairs *= coarse.grid.cell_points / problem.grid.cell_points
                solved.value = box, full, pairs, coarser
        box, full, pairs, coarser = solved.value
        target.agree(comm)
        if box is not None:
            return Candidate(None, pairs, coarser, box)
        return Candidate(_prolong(problem, self.step, coarse, solver, full, into), pairs, coarser)

    def _box_by(self, coarse: Problem, gap: np.ndarray, steps: Sequence[int]) -> Box | None:
        """Return the box around what touches on the next coarser grid. Collective on its ranks."""
        points = coarse.grid.inside[1]
        touching = Rectangle.of(coarse.grid, lambda i0, i1: gap[i0:i1, :points] <= 0)
        if touching is not None:
            touching = touching.times(steps)
        return Box.around(touching, self.grid, self.grids, coarse.grid.comm)


def roughly_solved(
    problem: Problem, make_solver: MakeSolver, g: np.ndarray, reduction: float, target: Target
) -> Solver:
    """Return a solver started from g, iterated until the residual falls by `reduction` or for
    MOST_ITERATIONS, without a certificate. Collective; raises Stopped on all ranks.
    """
    solver = make_solver(problem)
    solver.start(g)
    progress = solver.progress(target.is_sought)
    enough = reduction * progress.residual
    for _ in range(MOST_ITERATIONS):
        interrupt.check(problem.grid.comm)
        moved = target.follow(solver, progress, coarse=True)
        if not progress.finite or (not moved and progress.residual <= enough):
            break
        solver.step()
        progress = solver.progress(target.is_sought)
    return solver


def _prolong(
    problem: Problem,
    step: Decimation,
    coarse: Problem | None,
    solver: Solver | None,
    full: bool,
    into: np.ndarray | None,
) -> np.ndarray:
    """Interpolate a coarse solution, whose gap is overwritten, and correct it locally. Collective.
    coarse, solver: None without rows; full: the gap is 0; into: memory, perhaps the heights'.
    """
    fine = problem.grid
    real = problem.dtype.type
    out = fine.empty(problem.dtype) if into is None else into
    if full:
        out[...] = 0
        return out
    u = p = np.empty((0, step.n[1]), problem.dtype)
    if solver is not None and coarse is not None:
        u = solver.state.g
        p = solver.state.p
        grid = coarse.grid
        h = coarse.heights
        scale = real(grid.a / fine.a)
        inner, points = grid.inside

        def displacement(i0: int, i1: int) -> None:
            u[i0 : min(i1, inner), :points] -= h[i0:i1]
            u[i0:i1] *= scale

        grid.by_rows(displacement)
    heights = problem.heights
    pieces = fine.pieces()
    # beyond the surface there are no heights: what stands for them does not count
    owned = np.minimum(fine.starts, fine.nominal[0])
    before, after = neighbours(fine.comm, heights, fine.starts, SWEEPS, owned)
    borders = [heights[i - SWEEPS : i + SWEEPS] for i, _ in pieces[1:]]
    if np.may_share_memory(out, heights):  # other threads write there
        borders = [rows.copy() for rows in borders]
    befores = [before, *(rows[:SWEEPS] for rows in borders)]
    afters = [*(rows[SWEEPS:] for rows in borders), after]
    coarse_rows = int(step.beside[fine.comm.rank]), step.n[0]
    is_halved = tuple(k == 2 for k in step.steps)
    near = problem.body.near(fine)
    how = is_halved, gradient_steps(near, is_halved), near, problem.hardness
    fields = step.around(u), step.around(p)

    def prolong(i0: int, i1: int, before: np.ndarray, after: np.ndarray) -> None:
        h = (before, heights[i0:i1], after)
        rows = (fine.rows[0] + i0, fine.n[0])
        prolong_gap(*fields, h, out[i0:i1], rows, coarse_rows, *how, fine.nominal)

    arguments = [(*rows, *around) for rows, *around in zip(pieces, befores, afters)]
    on_threads(fine.threads, prolong, arguments)
    return out
