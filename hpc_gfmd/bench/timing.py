"""Times that can be compared: warmed up, alternating within one run, minimum and median of the repeats."""

import time
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Sample:
    """Seconds of the repeats, in the order in which they were taken; under MPI of the slowest rank."""

    seconds: tuple[float, ...]

    @property
    def min(self):
        return float(min(self.seconds))

    @property
    def median(self):
        return float(np.median(self.seconds))

    def record(self):
        """What a row of results says of it."""
        return {"seconds_min": self.min, "seconds_median": self.median, "repeats": len(self.seconds)}


def clock(run, comm=None):
    """Seconds of run() on the slowest rank. run may return a number of seconds that it measured itself."""
    if comm is not None:
        comm.barrier()
    begun = time.perf_counter()
    told = run()
    seconds = told if isinstance(told, float) else time.perf_counter() - begun
    return float(comm.max([seconds])[0]) if comm is not None else seconds


def alternate(runs, repeats, comm=None, warmup=1):
    """{name: Sample} of {name: function}: all in turn, every other round backwards (A B B A), so that a drift of the machine's speed
    hits all alike. The warm-up rounds are not timed."""
    seconds = {name: [] for name in runs}
    for _ in range(warmup):
        for run in runs.values():
            run()
    for k in range(repeats):
        for name in list(runs)[:: 1 if k % 2 == 0 else -1]:
            seconds[name].append(clock(runs[name], comm))
    return {name: Sample(tuple(s)) for name, s in seconds.items()}


def ratio(a, b):
    """Median over the repeats of a/b: of two samples that were taken in turn."""
    return float(np.median(np.divide(a.seconds, b.seconds)))
