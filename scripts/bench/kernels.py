"""The passes of the default solver during a solve, with copies and whole transforms in turn with
them, on one core and on several.

Reported are time and bytes per point, and the share of a copy's bandwidth. The bytes are those of
the fields that a pass has to read or write at least once. Neither data that stay in cache between
the parts of a pass nor lines that the memory system reads before they are overwritten count, for
the copy no more than for the passes. Cores are the ranks of one solve.
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

from .contacts import RoughContact
from .report import Report
from .timing import Stopwatch, ratio, run_workers, seconds, serve

ITERATIONS = 16  # after which the contact starts anew: a converged solution is no typical iterate


def run(args):
    """Report a row for each pass, copy and transform and each number of cores."""
    report = Report("kernels", args.out)
    for n, precision in product(args.n, args.precision):
        contact = {"n": n, "precision": precision, "p_star": args.p_star}
        jobs = {k: (k, contact | {"clock": args.clock}) for k in args.ranks}
        for cores, rounds in run_workers("kernels", jobs, args.repeats).items():
            times = {part: [row[part] for row in rounds] for part in rounds[0]}
            _add(report, times, contact | {"cores": cores})
    report.finish()


def _add(report, times, contact):
    """Report the times of every part, {part: seconds of each repetition}."""
    n = contact["n"]
    fields = field_passes([level.n for level in levels(Grid((n, n)))])
    fields |= {"iteration": sum(fields.values()), "copy": 2.0}
    for part, series in times.items():
        ns = 1e9 * min(series) / n**2
        row = {
            "ms_min": 1e3 * min(series),
            "ms_median": 1e3 * float(np.median(series)),
            "ns_per_point": ns,
            "iteration_over_this": ratio(times["iteration"], series),
        }
        if part in fields:
            nbytes = np.dtype(contact["precision"]).itemsize * fields[part]
            share = fields[part] / fields["copy"] * ratio(times["copy"], series)
            row |= {"bytes_per_point": nbytes, "gb_per_s": nbytes / ns, "share_of_copy": share}
        report.add(**contact, what=part, repeats=len(series), **row)


def field_passes(shapes):
    """Return how many fields of the fine grid each pass reads and writes.

    Parameters
    ----------
    shapes : list of (int, int)
        (n_x, n_y) of all levels, finest first.

    Returns
    -------
    dict of float
        Fields by the name of the pass.
    """
    share = [n_x * n_y / (shapes[0][0] * shapes[0][1]) for n_x, n_y in shapes]
    level_1 = share[1] if len(share) > 1 else 1.0
    coarser = sum(share[2:])
    d = 0.5  # the last step, in bfloat16
    spectrum = 1 + 2 / shapes[0][1]  # n_y/2 + 1 complex columns
    return {
        # read g, p, d and z of level 1; write d and the row spectra
        "search + rows": 2 + 2 * d + level_1 + spectrum,
        "columns": 2 * spectrum,
        # read row spectra, g, p, d; write g, p; write p, theta and x on level 1
        "update + rows": spectrum + 4 + d + 3 * level_1,
        # level 1: restrict p and theta, then read p, theta, x, write z; coarser ones: write and
        # read p and theta both ways, z
        "sweep": 6 * level_1 + 8 * coarser,
    }


def watch_passes(clock=time.perf_counter):
    """Return a Stopwatch that times the passes of all default solvers from now on."""
    watch = Stopwatch(clock)
    solver = solver_class("auto")
    watch.watch(solver, "_search", "search + rows")
    watch.watch(Elastic, "columns", "columns")
    watch.watch(solver, "_update", "update + rows")
    watch.watch(Multilevel, "sweep", "sweep")
    return watch


def worker(comm, n, precision, p_star, clock):
    """Return a function that times an iteration, its passes, a copy and whole transforms.

    Parameters
    ----------
    comm : SerialComm or MpiComm
        The ranks of the solve. Collective.
    n, precision, p_star
        Grid points along an axis, "single" or "double", and load.
    clock : str
        Name of a function of the module time.
    """
    dtype = np.dtype(precision)
    read_clock = getattr(time, clock)
    surface = RoughContact(n, p_star).build(comm, dtype)
    h = surface.h
    solver = solver_class("auto")(Problem(surface.grid, h, p_star), {})
    watch = watch_passes(read_clock)
    # Ones, not zeros: the system gives zeros no memory before they are written.
    source, target = np.ones((2, *h.shape), dtype)
    references = {"copy": lambda: np.copyto(target, source)} | bare_pairs((n, n), dtype, comm)
    iterations_left = 0

    def measure():
        nonlocal iterations_left
        if iterations_left == 0:
            solver.start(np.maximum(h - h.dtype.type(h.mean()), 0))
            solver.step()  # the first one is a plain projected gradient
            iterations_left = ITERATIONS
        iterations_left -= 1
        watch.take()
        iteration = seconds(solver.step, comm, read_clock)
        passes = {name: float(comm.max([elapsed])[0]) for name, elapsed in watch.take().items()}
        reference_times = {name: seconds(run, comm, read_clock) for name, run in references.items()}
        return passes | {"iteration": iteration} | reference_times

    return measure


def bare_pairs(n, dtype, comm):
    """Return {name: function} of transforms forward and back by other libraries.

    "PFFT" is mpi4py-fft as it plans by default; "FFTW 2-D", on one rank only, is FFTW alone.

    Parameters
    ----------
    n : (int, int)
        Grid points.
    dtype : numpy.dtype
        Of the field.
    comm : SerialComm or MpiComm
        Ranks that share the field. Collective.

    Raises
    ------
    GfmdError
        If mpi4py-fft is missing.
    """
    try:
        from mpi4py import MPI
        from mpi4py_fft import PFFT, fftw
    except ImportError as error:
        raise hpc_gfmd.GfmdError(f"mpi4py-fft cannot be imported: {error}") from None
    pfft = PFFT(comm.mpi if comm.size > 1 else MPI.COMM_SELF, n, dtype=dtype)
    pairs = {"PFFT": (pfft.forward, pfft.backward)}
    if comm.size == 1:
        x = fftw.aligned(n, dtype=dtype)
        q = fftw.aligned((n[0], n[1] // 2 + 1), dtype=np.result_type(dtype, np.complex64))
        flags = (fftw.FFTW_MEASURE,)
        forward = fftw.rfftn(x, None, (0, 1), 1, flags, q)
        pairs["FFTW 2-D"] = forward, fftw.irfftn(q, n, (0, 1), 1, flags, output_array=x)
    for transforms in pairs.values():
        for transform in transforms:
            transform.input_array[...] = 0

    def run(*pair):
        for transform in pair:
            transform(normalize=False)

    return {name: partial(run, *pair) for name, pair in pairs.items()}


if __name__ == "__main__":
    serve(worker)
