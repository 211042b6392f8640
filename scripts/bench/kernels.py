"""Passes of the default solver while it solves, copies and whole transforms in turn with them, on
one core and on more: time and bytes of a point, share of a copy's bandwidth.

Counted are the bytes of the fields that a pass has to read or write at least once; what stays in
cache between the parts of a pass, and lines that the memory system reads before they are
overwritten, are not, neither here nor for the copy. Cores: ranks of one solve.
"""

import time
from functools import partial
from itertools import product

import numpy as np

import hpc_gfmd
from hpc_gfmd.operators.elastic import Elastic
from hpc_gfmd.operators.multilevel import Multilevel
from hpc_gfmd.operators.problem import Problem
from hpc_gfmd.parallel.coarsening import levels
from hpc_gfmd.parallel.grid import Grid
from hpc_gfmd.solvers import solver_class

from .contacts import Case
from .report import Report
from .timing import Stopwatch, measured, ratio, seconds, serve

ITERATIONS = 16  # after which the contact is begun anew: what is iterated is not a solution


def run(args):
    """Report one row per pass, copy and transform, and number of cores; args: of command.py."""
    report = Report("kernels", args.out)
    for n, precision in product(args.n, args.precision):
        of = {"n": n, "precision": precision, "p_star": args.p_star}
        jobs = {k: (k, of | {"clock": args.clock}) for k in args.ranks}
        for cores, rounds in measured("kernels", jobs, args.repeats).items():
            series = {what: [row[what] for row in rounds] for what in rounds[0]}
            _add(report, series, of | {"cores": cores})
    report.finish()


def _add(report, series, of):
    moved = field_passes([level.n for level in levels(Grid((of["n"], of["n"])))])
    moved |= {"iteration": sum(moved.values()), "copy": 2.0}
    for what, taken in series.items():
        ns = 1e9 * min(taken) / of["n"] ** 2
        row = {
            "ms_min": 1e3 * min(taken),
            "ms_median": 1e3 * float(np.median(taken)),
            "ns_per_point": ns,
            "iteration_over_this": ratio(series["iteration"], taken),
        }
        if what in moved:
            nbytes = np.dtype(of["precision"]).itemsize * moved[what]
            share = moved[what] / moved["copy"] * ratio(series["copy"], taken)
            row |= {"bytes_per_point": nbytes, "gb_per_s": nbytes / ns, "share_of_copy": share}
        report.add(**of, what=what, repeats=len(taken), **row)


def field_passes(shapes):
    """Return {pass: fields read or written}, in fields of the fine grid; shapes: (n_x, n_y) of all
    levels, finest first."""
    share = [n_x * n_y / (shapes[0][0] * shapes[0][1]) for n_x, n_y in shapes]
    first, coarser = (share[1] if len(share) > 1 else 1.0), sum(share[2:])
    d = 0.5  # the last step, in bfloat16
    spectrum = 1 + 2 / shapes[0][1]  # n_y/2 + 1 complex columns
    return {
        # read g, p, d and z of level 1; write d and the row spectra
        "search + rows": 2 + 2 * d + first + spectrum,
        "columns": 2 * spectrum,
        # read row spectra, g, p, d; write g, p; write p, theta and x on level 1
        "update + rows": spectrum + 4 + d + 3 * first,
        # level 1: restrict p and theta, then read p, theta, x, write z; coarser ones: write and
        # read p and theta both ways, z
        "sweep": 6 * first + 8 * coarser,
    }


def watch_passes(now=time.perf_counter):
    """Return a stopwatch of the passes of all solvers from here on."""
    watch, solver = Stopwatch(now), solver_class("auto")
    watch.watch(solver, "_search", "search + rows")
    watch.watch(Elastic, "pressure_columns", "columns")
    watch.watch(solver, "_update", "update + rows")
    watch.watch(Multilevel, "sweep", "sweep")
    return watch


def worker(comm, n, precision, p_star, clock):
    """Return what measures the seconds of everything on the slowest rank."""
    dtype, now = np.dtype(precision), getattr(time, clock)
    surface = Case(n, p_star).build(comm, dtype)
    h = surface.h
    solver = solver_class("auto")(Problem(surface.grid, h, p_star), {})
    watch = watch_passes(now)
    # not zeros: those have no memory of their own yet
    source, target = np.ones((2, *h.shape), dtype)
    others = {"copy": lambda: np.copyto(target, source)} | bare_pairs((n, n), dtype, comm)
    left = 0

    def measure():
        nonlocal left
        if left == 0:
            solver.start(np.maximum(h - h.dtype.type(h.mean()), 0))
            solver.step()  # the first one is a plain projected gradient
            left = ITERATIONS
        left -= 1
        watch.take()
        whole = seconds(solver.step, comm, now)
        parts = {part: float(comm.max([spent])[0]) for part, spent in watch.take().items()}
        found = {name: seconds(run, comm, now) for name, run in others.items()}
        return parts | {"iteration": whole} | found

    return measure


def bare_pairs(n, dtype, comm):
    """Return {name: function} of mpi4py-fft's transforms forward and back as planned by default,
    and FFTW's alone on one rank. Raises GfmdError where it is missing."""
    try:
        from mpi4py import MPI
        from mpi4py_fft import PFFT, fftw
    except ImportError as error:
        raise hpc_gfmd.GfmdError(f"mpi4py-fft cannot be imported: {error}") from None
    pfft = PFFT(comm.mpi if comm.size > 1 else MPI.COMM_SELF, n, dtype=dtype)
    found = {"PFFT": (pfft.forward, pfft.backward)}
    if comm.size == 1:
        x = fftw.aligned(n, dtype=dtype)
        q = fftw.aligned((n[0], n[1] // 2 + 1), dtype=np.result_type(dtype, np.complex64))
        flags = (fftw.FFTW_MEASURE,)
        forward = fftw.rfftn(x, None, (0, 1), 1, flags, q)
        found["FFTW 2-D"] = forward, fftw.irfftn(q, n, (0, 1), 1, flags, output_array=x)
    for transforms in found.values():
        for transform in transforms:
            transform.input_array[...] = 0

    def run(*pair):
        for transform in pair:
            transform(normalize=False)

    return {name: partial(run, *pair) for name, pair in found.items()}


if __name__ == "__main__":
    serve(worker)
