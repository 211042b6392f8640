"""Passes of the default solver while it solves: bytes moved, share of a copy's bandwidth, iteration over bare FFT pair.

Counted are the fields that a pass has to read or write at least once; what stays in cache between the parts of a pass (row and column
transforms work on pieces of 256 KiB) and what the memory system adds on its own (reading lines that are about to be overwritten) is
not counted, neither here nor for the copy that they are compared with.
"""

import numpy as np

from ..parallel.world import world
from ..problem import Problem
from ..registry import solver_class
from .cases import DTYPES, Case
from .fft import bare_pairs
from .report import Report
from .timing import Clock, Sample, ratio

HURST = 0.8
COPY = 2.0  # fields that a copy moves: read one, write one
ITERATIONS = 16  # after which the contact is begun anew: what is iterated is not a solution
COLUMNS = {"n": ("n", "5d"), "precision": ("precision", "9"), "what": ("pass", "16"), "ms_min": ("ms (min)", "9.3f"),
           "ms_median": ("ms (median)", "11.3f"), "bytes_per_point": ("bytes/point", "11.1f"), "gb_per_s": ("GB/s", "7.2f"),
           "share_of_copy": ("of copy", "7.3f"), "iteration_over_this": ("iteration/this", "14.3f")}


class TimedSolver:
    """The default solver, begun from a flat plane, whose passes tell how long they took."""

    def __init__(self, case, dtype, comm, clock):
        surface = case.surface(dtype, comm)
        self.solver = solver_class("auto")(Problem(surface.grid, surface.h, case.p_star), {})
        self.clock = clock
        self.start = np.maximum(surface.h - surface.h.dtype.type(surface.h.mean()), 0)
        self.spent = {}
        solver = self.solver
        self._time(solver, "_search", "search + rows")
        self._time(solver.elastic, "pressure_columns", "columns")
        self._time(solver, "_update", "update + rows")
        self._time(solver.levels, "sweep", "sweep")
        self.left = 0

    def _time(self, owner, method, name):
        run = getattr(owner, method)

        def timed(*args):
            begun = self.clock.now()
            result = run(*args)
            self.spent[name] = self.spent.get(name, 0.0) + self.clock.now() - begun
            return result

        setattr(owner, method, timed)

    def __call__(self):
        if self.left == 0:
            self.solver.start(self.start)
            self.solver.step()  # the first one is a plain projected gradient
            self.left = ITERATIONS
        self.left -= 1
        self.spent = {}
        begun = self.clock.now()
        self.solver.step()
        self.spent["iteration"] = self.clock.now() - begun


def field_passes(shapes):
    """{pass: fields read or written}, in fields of the fine grid. shapes: (n_x, n_y) of all levels, finest first."""
    points = [n_x * n_y for n_x, n_y in shapes]
    share = [p / points[0] for p in points]
    first, coarser = (share[1] if len(share) > 1 else 1.0), sum(share[2:])
    spectrum = 1 + 2 / shapes[0][1]  # n_y/2 + 1 complex columns
    return {
        "search + rows": 3 + 1 + first + spectrum,  # read g, p, d and z of level 1; write d; write the row spectra
        "columns": 2 * spectrum,  # read and write
        "update + rows": spectrum + 3 + 2 + 3 * first,  # read row spectra, g, p, d; write g, p; write p, theta and x on level 1
        # level 1: restrict p and theta, then read p, theta, x, write z; coarser ones: write and read p and theta both ways, z
        "sweep": 6 * first + 8 * coarser,
    }


def bench_kernels(args):
    """One table row per pass, and for the iteration, the copy and the bare FFT pairs. args: n, precision (lists), p_star, repeats, cpu,
    out."""
    comm = world()
    clock = Clock(comm, args.cpu)
    report = Report("kernels", COLUMNS, args.out, comm)
    report.say(f"# H = {HURST}, p* = {args.p_star:g}; {clock.name} time; of copy: bandwidth over that of a copy in the same run; "
               "iteration/this: median over runs in turn")
    for n in args.n:
        for precision in args.precision:
            _one(n, precision, args.p_star, args.repeats, comm, clock, report)
    report.finish()


def _one(n, precision, p_star, repeats, comm, clock, report):
    dtype = DTYPES[precision]
    timed = TimedSolver(Case(n, HURST, p_star), dtype, comm, clock)
    grid = timed.solver.grid
    source, target = np.ones(grid.shape, dtype), np.ones(grid.shape, dtype)  # not zeros: those have no memory of their own yet
    others = {"copy": lambda: np.copyto(target, source)} | bare_pairs((n, n), dtype, comm)
    fields = field_passes([level.n for level in timed.solver.levels.levels])
    names = [*fields, "iteration"]
    seconds = {name: [] for name in [*names, *others]}
    for k in range(-2, repeats):
        for name in (["iteration", *others] if k % 2 == 0 else [*reversed(others), "iteration"]):
            if name != "iteration":
                taken = {name: clock.measure(others[name])}
            else:
                comm.barrier()
                if timed.left == 0:
                    timed()  # begins anew: not counted
                timed()
                taken = {part: clock.slowest(timed.spent.get(part, 0.0)) for part in names}
            if k >= 0:
                for part, value in taken.items():
                    seconds[part].append(value)
    samples = {name: Sample(tuple(s)) for name, s in seconds.items()}
    size = np.dtype(dtype).itemsize
    counted = {name: f * size for name, f in fields.items()} | {"iteration": sum(fields.values()) * size, "copy": COPY * size}
    N = n * n
    copy = COPY * size / samples["copy"].median
    for name, sample in samples.items():
        row = {"n": n, "precision": precision, "what": name, "p_star": p_star, "clock": clock.name, "repeats": repeats,
               "ms_min": 1e3 * sample.min, "ms_median": 1e3 * sample.median,
               "iteration_over_this": ratio(samples["iteration"], sample)}
        if name in counted:
            row |= {"bytes_per_point": counted[name], "gb_per_s": 1e-9 * N * counted[name] / sample.min,
                    "share_of_copy": counted[name] / sample.median / copy}
        report.add(**row)
