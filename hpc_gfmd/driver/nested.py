"""Nested start: solve on decimated grids first, each to a few per cent, and interpolate the displacement to the next finer grid.

The finer grid's own heights are then given way to locally, without an FFT (kernels/prolong.py): that saves one or two iterations.

Decimation (every second point) keeps the heights of the asperities; averages and envelopes do not, and start worse at small loads.
"""

from dataclasses import replace

import numpy as np

from ..grid import Grid
from ..kernels.prolong import HALO, SWEEPS, prolong_gap
from ..operators.coarsening import levels
from ..parallel import halo
from ..parallel.comm import SerialComm
from .certificate import certify

COARSEST = 32  # points along an axis below which there is no coarser grid
RESIDUAL = 0.2  # of the coarse solutions
ITERATIONS = 60  # at most, on a coarse grid
WHOLE_POINTS = 256 * 256  # grids of at most this many points are solved by every rank alone
THIN_ROWS = 4  # and so are grids of which some rank has fewer rows
TENSION = 0.02  # share of points under tension in a closed coarse contact up to which the fine one may be without any
FLAT_START = 0.099  # p* below which the flat start rests on the heights above mean + rms; not a round number: p* has rounding errors


def cold_gap(problem):
    """A flat displacement pressed into the surface: the gap of a rigid plane at a height that suits the load.

    Beyond the surface the displacement is that of the plane.
    """
    h, comm, N = problem.h, problem.grid.comm, problem.grid.N
    s1, s2 = comm.sum([h.sum(dtype=np.float64), np.einsum("ij,ij->", h, h, dtype=np.float64)])
    mean = s1 / N
    level = mean
    if problem.p0 < FLAT_START:
        level = mean - np.sqrt(max(s2 / N - mean * mean, 0.0))
    level = h.dtype.type(max(level, 0.0))
    rows, points = problem.grid.inside
    g = np.empty(problem.grid.shape, h.dtype) if problem.grid.padded else np.empty_like(h)
    g[rows:], g[:rows, points:] = -level, -level
    np.maximum(h - level, 0, out=g[:rows, :points])
    return g


def coarser_grid(grid):
    """The decimated grid whose rows live with the fine rows they are taken from, or None where the grid is coarse already."""
    n = levels(grid)[1].n if grid.cell_points > 1 else (1, 1)
    coarsened = [a != b for a, b in zip(n, grid.n)]
    if min((k for k, c in zip(n, coarsened) if c), default=0) < COARSEST:
        return None
    starts = (grid.starts + 1) // 2 if coarsened[0] else grid.starts
    nominal = [(k + 1) // 2 if c else k for k, c in zip(grid.nominal, coarsened)]
    return Grid(n, grid.sizes, grid.comm, grid.threads, starts, nominal)


class Nested:
    """The decimated grids of a grid, planned once; `start` solves on them."""

    def __init__(self, grid, dtype):
        self.steps = []  # (fine grid, its decimation), finest first
        while (coarse := coarser_grid(grid)) is not None:
            thin = np.diff(coarse.starts).min() < THIN_ROWS
            if grid.comm.size > 1 and (coarse.cell_points <= WHOLE_POINTS or thin):
                coarse = Grid(coarse.n, coarse.sizes, SerialComm(), coarse.threads, nominal=coarse.nominal)
            coarse.fft(dtype)
            self.steps.append((grid, coarse))
            grid = coarse

    def start(self, problem, make_solver, into=None):
        """A starting gap (local slab) for a problem on the grid, and the FFT pairs that it took, in pairs of that grid.

        into: memory for the gap; may be that of problem.h, which is then lost.
        """
        problems = [problem]
        for fine, coarse in self.steps:
            problems.append(_decimated(problems[-1], fine, coarse))
        g, pairs = cold_gap(problems[-1]), 0.0
        for fine, coarse in zip(problems[-2::-1], problems[:0:-1], strict=True):
            solver = make_solver(coarse)
            solver.start(g)
            for _ in range(ITERATIONS):
                progress = solver.progress()
                if progress.residual < RESIDUAL or not progress.finite:
                    break
                solver.step()
            pairs = (pairs + solver.pairs) * coarse.grid.cell_points / fine.grid.cell_points
            full = not coarse.grid.padded and solver.progress().contact == coarse.grid.N
            if coarse.grid.comm.size != fine.grid.comm.size:  # each rank solved alone: were they to round differently, one must count
                solver.g[...], solver.p[...], full, pairs = fine.grid.comm.bcast((solver.g, solver.p, full, pairs))
            g = _prolong(fine, coarse, solver, full, into if fine is problem else None)
        if into is not None and g is not into:  # no coarser grid
            into[...] = g
            g = into
        return g, pairs

    def may_be_full(self, problem):
        """Whether full contact is likely, and the FFT pairs this took: from the pressure of the closed contact on the next grid."""
        if not self.steps:
            return True, 0.0
        coarse = _decimated(problem, *self.steps[0])
        g, p = np.zeros_like(coarse.h), np.empty_like(coarse.h)
        certificate = certify(coarse, g, p, dtype=coarse.dtype.type)
        share = coarse.grid.N / problem.grid.N
        likely = certificate.contact >= (1 - TENSION) * coarse.grid.N
        return problem.grid.comm.bcast(likely), certificate.pairs * share


def _decimated(problem, fine, grid):
    """The problem of every second point. Units of height and pressure stay, lengths become those of the coarser grid."""
    step = [2 if a != b else 1 for a, b in zip(grid.n, fine.n, strict=True)]
    h = np.ascontiguousarray(problem.h[(-fine.rows[0]) % step[0]::step[0], ::step[1]])
    if grid.comm.size != fine.comm.size:
        h = np.concatenate(fine.comm.allgather(h))
    return replace(problem, grid=grid, h=h / h.dtype.type(grid.a / fine.a))


def _prolong(problem, coarse, solver, full, into):
    """The gap on the grid of `problem` from a solver's on the coarse one, whose gap is lost. into: memory for it, or None."""
    fine = problem.grid
    out = fine.empty(problem.dtype) if into is None else into
    if full:
        out[...] = 0
        return out
    real = problem.dtype.type
    u = solver.g
    rows, points = coarse.grid.inside
    u[:rows, :points] -= coarse.h
    u *= real(coarse.grid.a / fine.a)
    start, stop = fine.rows
    halved = tuple(m != n for m, n in zip(coarse.grid.n, fine.n))
    first, last = (-(-i // 2) if halved[0] else i for i in (start, stop))
    spread = coarse.grid.comm.size == fine.comm.size

    def with_halo(a):
        if spread:
            before, after = halo.neighbours(fine.comm, a, HALO)
            return before, a, after
        take = np.arange(first - HALO, last + HALO) % len(a)  # every rank has all of it
        return a[take[:HALO]], a[first:last], a[take[len(take) - HALO:]]

    before, after = _heights_around(problem)
    heights, rows, coarse_rows = (before, problem.h, after), (start, fine.n[0]), (first, coarse.grid.n[0])
    prolong_gap(with_halo(u), with_halo(solver.p), heights, out, rows, coarse_rows, halved, real(1 / problem.body.scale(fine)),
                problem.body.near(fine).astype(problem.dtype), fine.nominal)
    return out


def _heights_around(problem):
    """The rows of h before and after this rank's rows of the grid; beyond the surface there are none that count."""
    grid, h = problem.grid, problem.h
    if grid.padded:  # of the rows of the grid the outermost ones are enough
        i = np.arange(grid.shape[0])
        i = i if len(i) <= 2 * SWEEPS else np.concatenate([i[:SWEEPS], i[-SWEEPS:]])
        h = np.concatenate([h, np.zeros((1, h.shape[1]), h.dtype)])[np.minimum(i, len(h))]
    return halo.neighbours(grid.comm, h, SWEEPS)
