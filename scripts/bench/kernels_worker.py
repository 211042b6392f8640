"""The passes of a solve timed on some ranks, a copy and the bare FFT pairs in turn with them.
Started by kernels.py."""

import sys
from collections.abc import Sequence

import numpy as np
from numpy.typing import DTypeLike

from hpc_gfmd.operators.problem import Problem
from hpc_gfmd.parallel.comm import Comm
from hpc_gfmd.parallel.world import world
from hpc_gfmd.solvers import solver_class

from .cases import DTYPES, Case
from .fft import bare_pairs
from .timing import Clock, Stopwatch
from .workers import serve

HURST = 0.8
ITERATIONS = 16  # after which the contact is begun anew: what is iterated is not a solution


class TimedSolver:
    """The default solver, begun from a flat plane, whose passes tell how long they took."""

    def __init__(self, case: Case, dtype: DTypeLike, comm: Comm, clock: Clock):
        surface = case.surface(dtype, comm)
        h = surface.h
        assert h is not None
        self.solver = solver_class("auto")(Problem(surface.grid, h, case.p_star), {})
        self.start = np.maximum(h - h.dtype.type(h.mean()), 0)
        self.left, solver = 0, self.solver
        parts = {
            "search + rows": (solver, "_search"),
            "columns": (solver.elastic, "pressure_columns"),
            "update + rows": (solver, "_update"),
            "sweep": (solver.levels, "sweep"),
        }
        self.watch = Stopwatch(parts, clock.now)
        for name, (owner, method) in parts.items():
            self.watch.watch(owner, method, name)

    def __call__(self) -> None:
        if self.left == 0:
            self.solver.start(self.start)
            self.solver.step()  # the first one is a plain projected gradient
            self.left = ITERATIONS
        self.left -= 1
        self.watch.reset()
        begun = self.watch.now()
        self.solver.step()
        self.watch.seconds["iteration"] = self.watch.now() - begun


def main(argv: Sequence[str]) -> None:
    """Measure as often as kernels.py asks."""
    n, dtype, p_star, cpu = int(argv[0]), DTYPES[argv[1]], float(argv[2]), argv[3] == "cpu"
    comm = world()
    clock = Clock(comm, cpu)
    timed = TimedSolver(Case(n, HURST, p_star), dtype, comm, clock)
    shape = timed.solver.grid.shape
    source, target = (
        np.ones(shape, dtype),
        np.ones(shape, dtype),
    )  # not zeros: those have no memory of their own yet
    others = {"copy": lambda: np.copyto(target, source)} | bare_pairs((n, n), dtype, comm)

    def measure() -> dict[str, float]:
        """Seconds of everything on the slowest rank."""
        comm.barrier()
        if timed.left == 0:
            timed()  # begins anew: not counted
        timed()
        return {part: clock.slowest(spent) for part, spent in timed.watch.seconds.items()} | {
            name: clock.measure(run) for name, run in others.items()
        }

    measure()  # warm
    serve(comm, measure)


if __name__ == "__main__":
    main(sys.argv[1:])
