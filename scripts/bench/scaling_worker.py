"""One measured solve: where its time goes. Started by scaling.py, alone or under mpirun."""

import sys
import time
from collections.abc import Sequence
from typing import Any

from hpc_gfmd.driver.sweep import Sweep
from hpc_gfmd.driver.warmup import compile_once
from hpc_gfmd.parallel.world import world
from hpc_gfmd.scene import Solver

from .cases import Case
from .timing import Stopwatch
from .workers import serve

PARTS = ("fft", "transpose", "levels", "reductions")
# solves of a process before the first that counts: until then the system still finds it large pages
WARM_UP = 3


class TimedMpi:
    """An mpi4py communicator whose calls are timed: all-to-alls, and all of a node that transposes
    together, apart from the rest."""

    def __init__(self, mpi: Any, watch: Stopwatch, rest: str):
        self._mpi, self._watch, self._rest = mpi, watch, rest

    def __getattr__(self, name: str) -> Any:
        value = getattr(self._mpi, name)
        if name.startswith("Alltoall"):
            return self._watch.timed("transpose", value)
        if name in ("Allreduce", "Bcast", "Barrier", "Waitall"):
            return self._watch.timed(self._rest, value)
        return value


def main(argv: Sequence[str]) -> int:
    """Solve as often as scaling.py asks."""
    n, p_star, accuracy, threads = int(argv[0]), float(argv[2]), float(argv[3]), int(argv[4])
    precision: Any = argv[1]
    comm = world()
    settings = Solver(precision=precision, accuracy=accuracy)
    compile_once(comm, settings)
    watch = Stopwatch(PARTS)
    sweep = Sweep(lambda dtype: Case(n, 0.8, p_star).surface(dtype, comm, threads), settings)
    for part in (comm, comm.node):
        if part.mpi is not None:
            part.mpi = TimedMpi(part.mpi, watch, "transpose" if part is comm.node else "reductions")

    def measure() -> dict[str, Any]:
        sweep.solver = None
        if threads == 1:  # a stopwatch for several threads at once would count their time twice
            _instrument(sweep, watch)
        comm.barrier()
        watch.reset()
        begun = time.perf_counter()
        step = sweep.solve(p_star * sweep.surface.g_rms)
        comm.barrier()
        seconds = time.perf_counter() - begun
        parts = dict(zip(PARTS, comm.sum(list(watch.seconds.values())) / comm.size, strict=True))
        parts["kernels"] = seconds - sum(parts.values())
        return {
            "n": n,
            "ranks": comm.size,
            "threads": threads,
            "precision": precision,
            "p_star": p_star,
            "accuracy": accuracy,
            "seconds": seconds,
            "parts": parts,
            "iterations": step.iterations,
            "fft_pairs": step.fft_pairs,
            "status": step.contact.outcome.status,
        }

    for _ in range(WARM_UP):
        measure()
    serve(comm, measure)
    return 0


def _instrument(sweep: Any, watch: Stopwatch) -> None:
    """Time the transforms of all grids, and the sweep over the levels of every solver that is
    made."""
    grids = [sweep.surface.grid] + (sweep.nested.grids if sweep.nested else [])
    for grid in grids:
        for fft in grid.planned():
            if not hasattr(fft.plans, "is_timed"):
                for name in (
                    "rows_forward",
                    "rows_backward",
                    "columns_forward",
                    "columns_backward",
                ):
                    watch.watch(fft.plans, name, "fft")
                fft.plans.is_timed = True
    make = type(sweep)._make

    def timed_make(*args: Any) -> Any:
        solver = make(sweep, *args)
        if hasattr(solver, "levels"):
            watch.watch(solver.levels, "sweep", "levels")
        return solver

    sweep._make = timed_make


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
