"""Nested start: solve on decimated grids first, each to a few per cent, and interpolate the displacement to the next finer grid.

Decimation (every second point) keeps the heights of the asperities; averages and envelopes do not, and start worse at small loads.
"""

import numpy as np

from ..coarsening import levels
from ..grid import Grid
from ..kernels.prolong import prolong_gap
from ..parallel import halo
from ..parallel.comm import SerialComm
from ..problem import Problem

COARSEST = 32  # points along an axis below which there is no coarser grid
RESIDUAL = 0.03  # of the coarse solutions
ITERATIONS = 60  # at most, on a coarse grid
WHOLE_POINTS = 256 * 256  # grids of at most this many points are solved by every rank alone
FLAT_START = 0.1  # p* below which the flat start rests on the heights above mean + rms


def cold_gap(problem):
    """A flat displacement pressed into the surface: the gap of a rigid plane at a height that suits the load."""
    h, comm, N = problem.h, problem.grid.comm, problem.grid.N
    s1, s2 = comm.sum([h.sum(dtype=np.float64), np.vdot(h, h)])
    mean = s1 / N
    level = mean
    if problem.p0 < FLAT_START:
        level = mean - np.sqrt(max(s2 / N - mean * mean, 0.0))
    g = h - h.dtype.type(max(level, 0.0))
    return np.maximum(g, 0, out=g)


def coarser_grid(grid):
    """The decimated grid whose rows live with the fine rows they are taken from, or None where the grid is coarse already."""
    n = levels(grid)[1].n if grid.N > 1 else (1, 1)
    coarsened = [a != b for a, b in zip(n, grid.n)]
    if min((k for k, c in zip(n, coarsened) if c), default=0) < COARSEST:
        return None
    starts = (grid.starts + 1) // 2 if coarsened[0] else grid.starts
    return Grid(n, grid.sizes, grid.comm, grid.threads, starts)


def nested_gap(problem, make_solver):
    """A starting gap (local slab) for a problem, and the FFT pairs that it took, in pairs of the problem's grid."""
    coarse = _coarser(problem)
    if coarse is None:
        return cold_gap(problem), 0.0
    g, pairs = nested_gap(coarse, make_solver)
    solver = make_solver(coarse)
    solver.start(g)
    for _ in range(ITERATIONS):
        progress = solver.progress()
        if progress.residual < RESIDUAL or not progress.finite:
            break
        solver.step()
    pairs = (pairs + solver.pairs) * coarse.grid.N / problem.grid.N
    return _prolong(problem, coarse, solver.g, full=solver.progress().contact == coarse.grid.N), pairs


def _coarser(problem):
    grid = coarser_grid(problem.grid)
    if grid is None:
        return None
    step = [2 if a != b else 1 for a, b in zip(grid.n, problem.grid.n)]
    start = problem.grid.rows[0]
    h = np.ascontiguousarray(problem.h[(-start) % step[0]::step[0], ::step[1]])
    thin = np.diff(grid.starts).min() < 4
    if grid.comm.size > 1 and (grid.N <= WHOLE_POINTS or thin):
        h = np.concatenate(grid.comm.allgather(h))
        grid = Grid(grid.n, grid.sizes, SerialComm())
    # Units of height and pressure stay those of the fine grid, lengths become those of the coarse one.
    ratio = grid.a / problem.grid.a
    return Problem(grid, h / h.dtype.type(ratio), problem.p0)


def _prolong(problem, coarse, g, full):
    """max(P u, -h) + h with cubic interpolation along each axis."""
    fine = problem.grid
    if full:
        return np.zeros(fine.shape, problem.dtype)
    ratio = problem.dtype.type(coarse.grid.a / fine.a)
    u = g
    np.subtract(g, coarse.h, out=u)
    u *= ratio
    start, stop = fine.rows
    step_x = 2 if coarse.grid.n[0] != fine.n[0] else 1
    if coarse.grid.comm.size == fine.comm.size:
        first, (before, after) = coarse.grid.rows[0], halo.neighbours(fine.comm, u, 2)
    else:  # every rank has all of it
        n = coarse.grid.n[0]
        first, last = -(-start // step_x), -(-stop // step_x)
        take = np.arange(first - 2, last + 2) % n
        before, u, after = u[take[:2]], u[take[2:-2]], u[take[-2:]]
    u = np.concatenate([before, u, after])
    out = fine.empty(problem.dtype)
    prolong_gap(u, problem.h, out, start, first - 2, step_x, coarse.grid.n[1] != fine.n[1])
    return out
