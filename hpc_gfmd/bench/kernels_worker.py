"""The passes of a solve timed on some ranks, a copy and the bare FFT pairs in turn with them. Started by kernels.py."""

import sys
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import DTypeLike

from ..parallel.comm import Comm
from ..parallel.world import world
from ..problem import Problem
from ..registry import solver_class
from .cases import DTYPES, Case
from .fft import bare_pairs
from .timing import Clock
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
        self.clock = clock
        self.start = np.maximum(h - h.dtype.type(h.mean()), 0)
        self.spent: dict[str, float] = {}
        solver = self.solver
        self._time(solver, "_search", "search + rows")
        self._time(solver.elastic, "pressure_columns", "columns")
        self._time(solver, "_update", "update + rows")
        self._time(solver.levels, "sweep", "sweep")
        self.left = 0

    def _time(self, owner: object, method: str, name: str) -> None:
        run = getattr(owner, method)

        def timed(*args: Any) -> Any:
            begun = self.clock.now()
            result = run(*args)
            self.spent[name] = self.spent.get(name, 0.0) + self.clock.now() - begun
            return result

        setattr(owner, method, timed)

    def __call__(self) -> None:
        if self.left == 0:
            self.solver.start(self.start)
            self.solver.step()  # the first one is a plain projected gradient
            self.left = ITERATIONS
        self.left -= 1
        self.spent = {}
        begun = self.clock.now()
        self.solver.step()
        self.spent["iteration"] = self.clock.now() - begun


def main(argv: Sequence[str]) -> None:
    """Measure as often as kernels.py asks."""
    n, dtype, p_star, cpu = int(argv[0]), DTYPES[argv[1]], float(argv[2]), argv[3] == "cpu"
    comm = world()
    clock = Clock(comm, cpu)
    timed = TimedSolver(Case(n, HURST, p_star), dtype, comm, clock)
    shape = timed.solver.grid.shape
    source, target = np.ones(shape, dtype), np.ones(shape, dtype)  # not zeros: those have no memory of their own yet
    others = {"copy": lambda: np.copyto(target, source)} | bare_pairs((n, n), dtype, comm)

    def measure() -> dict[str, float]:
        """Seconds of everything on the slowest rank."""
        comm.barrier()
        if timed.left == 0:
            timed()  # begins anew: not counted
        timed()
        return {part: clock.slowest(spent) for part, spent in timed.spent.items()} | {name: clock.measure(run)
                                                                                     for name, run in others.items()}

    measure()  # warm
    serve(comm, measure)


if __name__ == "__main__":
    main(sys.argv[1:])
