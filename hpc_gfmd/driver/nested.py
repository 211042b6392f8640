"""Nested iteration (cascadic multigrid): solve on decimated grids first, roughly, and interpolate
the displacement to the next finer grid.

The finer grid's own heights are then given way to locally, without an FFT (kernels/prolong.py):
that saves one or two iterations.

Decimation (every second point) keeps the heights of the asperities; averages and envelopes do not,
and start worse at small loads.

Coarse grids are agglomerated on fewer and fewer ranks: the others wait until the solution comes
back to their rows.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import DTypeLike

from ..kernels.prolong import HALO, SWEEPS, prolong_gap
from ..parallel import interrupt
from ..parallel.coarsening import agglomerated, halved
from ..parallel.grid import Grid
from ..parallel.halo import neighbours, rows_of
from ..parallel.threads import on_threads, threads_for
from .full_contact import closed_contact

if TYPE_CHECKING:
    from ..operators.problem import Problem
    from ..solvers.base import Solver
    from .search import LoadSearch

    MakeSolver = Callable[[Problem], Solver]

SLIM = 4  # points that a cubic takes: an axis of fewer is not decimated


@dataclass(frozen=True)
class NestedCalibration:
    """How the coarse grids are solved.

    Measured by the pairs and the time of self-affine walls: errors are those of the finest grid.

    Attributes
    ----------
    coarsest : int
        Points along an axis, in the geometric mean, below which there is no coarser grid.
    reduction : float
        Residual of a coarse solution over that of its start, for each grid that is finer: what a
        finer grid adds is about what this one adds to the coarser, so that a better solution is of
        no use, but the coarser, the cheaper it is.
    iterations : int
        At most, on a coarse grid.
    rank_points : int
        Of a coarse grid on one rank, at least: fewer are solved faster than they are sent.
    tension : float
        Share of points under tension in a closed coarse contact up to which the fine one may be
        without any.
    """

    coarsest: int = 32
    reduction: float = 0.6
    iterations: int = 60
    rank_points: int = field(default=2**13, metadata={"measured": "scripts/bench scaling"})
    tension: float = 0.02


CALIBRATION = NestedCalibration()


def cold_gap(problem: Problem) -> np.ndarray:
    """Press a flat displacement into the surface: the gap of a rigid plane that rests on the
    heights above mean + rms.

    Beyond the surface the displacement is that of the plane.
    """
    h = problem.heights
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
    """Return the gap of the undeformed body, with a displacement of 0 everywhere."""
    h = problem.heights
    rows, points = problem.grid.inside
    g = np.zeros(problem.grid.shape, h.dtype)
    g[:rows, :points] = h
    return g


@dataclass(frozen=True)
class Decimation:
    """A grid and its decimation.

    Attributes
    ----------
    fine : Grid
        The grid.
    coarse : Grid or None
        Its decimation; None on ranks that have no part in it.
    n : (int, int)
        Points of the decimation.
    nominal : (int, int)
        Of these, those of the surface.
    beside : ndarray of int
        First coarse row among the fine rows of every rank, and the number of rows.
    starts : ndarray of int
        First coarse row that every rank owns, and the number of rows.
    """

    fine: Grid
    coarse: Grid | None
    n: tuple[int, int]
    nominal: tuple[int, int]
    beside: np.ndarray
    starts: np.ndarray

    @classmethod
    def of(cls, grid: Grid) -> Decimation | None:
        """Decimate a grid; None where it is coarse already. Takes no memory, but communicators:
        collective."""
        n, _ = halved(grid.n, grid.spacings, SLIM)
        coarsened = [a != b for a, b in zip(n, grid.n)]
        points = [k for k, c in zip(n, coarsened) if c]
        if not points or np.prod(points) < CALIBRATION.coarsest ** len(points):
            return None
        beside = (grid.starts + 1) // 2 if coarsened[0] else grid.starts
        n_x, n_y = ((k + 1) // 2 if c else k for k, c in zip(grid.nominal, coarsened))
        starts = agglomerated(beside, n[0] * n[1], CALIBRATION.rank_points)
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
        """Fine points to a coarse one along each axis."""
        return [2 if a != b else 1 for a, b in zip(self.n, self.fine.n, strict=True)]

    def problem(self, problem: Problem) -> Problem | None:
        """Return the problem of every second point, None where this rank has none. Units of height
        and pressure stay, lengths become those of the coarser grid. Collective."""
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
        return replace(problem, grid=self.coarse, h=heights)

    def around(self, a: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the rows of a coarse field beside this rank's fine rows: HALO before, these, and
        HALO after them. a: this rank's own rows of it, perhaps none. Collective."""
        comm = self.fine.comm
        if np.array_equal(self.beside, self.starts):
            before, after = neighbours(comm, a, self.starts, HALO)
            return before, a, after
        rows = rows_of(comm, a, self.starts, self.beside[:-1] - HALO, self.beside[1:] + HALO)
        return rows[:HALO], rows[HALO:-HALO], rows[-HALO:]


class Nested:
    """The decimated grids of a grid, planned once. Collective, as are its methods.

    Parameters
    ----------
    grid : Grid
        The grid whose contacts are started.
    dtype : dtype
        The working precision.
    finer : int
        Number of grids that are finer.
    """

    def __init__(self, grid: Grid, dtype: DTypeLike, finer: int = 0):
        self.grid = grid
        self.step = Decimation.of(grid)
        self.coarser: Nested | None = None
        self.reduction = CALIBRATION.reduction ** (finer + 1)
        if self.step is not None and self.step.coarse is not None:
            self.step.coarse.fft(dtype)
            self.coarser = Nested(self.step.coarse, dtype, finer + 1)

    @property
    def is_coarsest(self) -> bool:
        """Whether the grid has no coarser one, the same on all ranks."""
        return self.step is None

    @property
    def grids(self) -> list[Grid]:
        """The coarse grids that this rank has a part in, finest first."""
        return [self.coarser.grid, *self.coarser.grids] if self.coarser is not None else []

    def start(
        self,
        problem: Problem,
        make_solver: MakeSolver,
        search: LoadSearch | None,
        into: np.ndarray | None = None,
    ) -> tuple[np.ndarray, float]:
        """Solve a problem on the coarser grids, and interpolate the solution.

        Parameters
        ----------
        problem : Problem
            On the grid, with stored heights.
        make_solver : callable
            Makes the solver of a problem: ``make_solver(problem)``.
        search : LoadSearch or None
            Finds the mean pressure on every grid; None where it is given.
        into : ndarray, optional
            Memory for the gap; may be that of problem.h, which is then lost.

        Returns
        -------
        gap : ndarray
            To start from, local slab of the grid.
        pairs : float
            FFT pairs that it took, in pairs of this grid.

        Raises
        ------
        Stopped
            On all ranks, when the run is to stop.
        """
        if self.step is None:
            g = cold_gap(problem)
            if into is not None:
                into[...] = g
            return (g if into is None else into), 0.0
        coarse = self.step.problem(problem)
        solver = None
        full = False
        pairs = 0.0
        signal = 0
        if coarse is not None and self.coarser is not None:
            try:
                g, pairs = self.coarser.start(coarse, make_solver, search)
                if search is not None:
                    coarse = replace(coarse, p0=search.begin(coarse))
                solver = roughly_solved(coarse, make_solver, g, self.reduction, search)
                pairs = (pairs + solver.pairs) * coarse.grid.cell_points / problem.grid.cell_points
                full = not coarse.grid.padded and solver.progress().contact == coarse.grid.N
            except interrupt.Stopped as stopped:
                signal = stopped.number
        # rank 0 has a part in all grids
        full, pairs, signal = problem.grid.comm.bcast((full, pairs, signal))
        if signal:
            interrupt.stop(signal)
        if search is not None:
            search.agree(problem.grid.comm)
        return _prolong(problem, self.step, coarse, solver, full, into), pairs

    def may_be_full(self, problem: Problem) -> tuple[bool, float]:
        """Return whether full contact is likely, by the pressure of the closed contact on the next
        grid, and the FFT pairs this took."""
        if self.step is None:
            return True, 0.0
        coarse = self.step.problem(problem)
        likely = False
        pairs = 0.0
        if coarse is not None:
            _, _, certificate = closed_contact(coarse, coarse.dtype)
            pairs = certificate.pairs * (coarse.grid.N / problem.grid.N)
            elastic = certificate.contact - certificate.yielded
            likely = elastic >= (1 - CALIBRATION.tension) * coarse.grid.N
        return problem.grid.comm.bcast((likely, pairs))


def roughly_solved(
    problem: Problem,
    make_solver: MakeSolver,
    g: np.ndarray,
    reduction: float,
    search: LoadSearch | None,
) -> Solver:
    """Iterate a solver until its residual is small enough for a coarse grid. Collective.

    Parameters
    ----------
    problem : Problem
        On the coarse grid.
    make_solver : callable
        Makes the solver of a problem.
    g : ndarray
        Gap to start from, local slab.
    reduction : float
        Residual to come to, over that of the start.
    search : LoadSearch or None
        Finds the mean pressure meanwhile.

    Returns
    -------
    Solver
        With the solution.

    Raises
    ------
    Stopped
        On all ranks, when the run is to stop.
    """
    solver = make_solver(problem)
    solver.start(g)
    progress = solver.progress()
    enough = reduction * progress.residual
    for _ in range(CALIBRATION.iterations):
        interrupt.check(problem.grid.comm)
        near = search is None or search.near(solver, progress)
        if not progress.finite or (near and progress.residual <= enough):
            break
        solver.step()
        progress = solver.progress()
    return solver


def _prolong(
    problem: Problem,
    step: Decimation,
    coarse: Problem | None,
    solver: Solver | None,
    full: bool,
    into: np.ndarray | None,
) -> np.ndarray:
    """Return the gap on the grid of `problem` from a solver on the coarse one, whose gap is lost;
    coarse and solver: the coarse problem, None where this rank has no part in it. into: memory for
    the gap, or None."""
    fine = problem.grid
    real = problem.dtype.type
    out = fine.empty(problem.dtype) if into is None else into
    if full:
        out[...] = 0
        return out
    u = p = np.empty((0, step.n[1]), problem.dtype)
    if solver is not None and coarse is not None:
        u = solver.g
        p = solver.p
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
    # copies: where `out` is the memory of the heights, other threads write to it
    borders = [heights[i - SWEEPS : i + SWEEPS].copy() for i, _ in pieces[1:]]
    befores = [before, *(rows[:SWEEPS] for rows in borders)]
    afters = [*(rows[SWEEPS:] for rows in borders), after]
    coarse_rows = int(step.beside[fine.comm.rank]), step.n[0]
    is_halved = tuple(k == 2 for k in step.steps)
    compliance = 1 / problem.body.scale(fine)
    deepest = np.inf if problem.hardness is None else compliance * problem.hardness
    near = problem.body.near(fine).astype(problem.dtype)
    how = is_halved, real(compliance), near, real(deepest)
    fields = step.around(u), step.around(p)

    def prolong(i0: int, i1: int, before: np.ndarray, after: np.ndarray) -> None:
        h = (before, heights[i0:i1], after)
        rows = (fine.rows[0] + i0, fine.n[0])
        prolong_gap(*fields, h, out[i0:i1], rows, coarse_rows, *how, fine.nominal)

    arguments = [(*rows, *around) for rows, *around in zip(pieces, befores, afters)]
    on_threads(fine.threads, prolong, arguments)
    return out
