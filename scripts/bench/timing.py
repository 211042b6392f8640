"""Times that can be compared: warmed up, alternating within one run, minimum and median of the
repeats."""

import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from hpc_gfmd.parallel.comm import Comm

K = TypeVar("K")


class Stopwatch:
    """Adds up seconds by name, by the clock `now`; time of inner parts is not counted in outer
    ones."""

    def __init__(self, parts: Iterable[str], now: Callable[[], float] = time.perf_counter):
        self.parts, self.now, self.inner = tuple(parts), now, 0.0
        self.reset()

    def reset(self) -> None:
        """Begin at 0."""
        self.seconds = dict.fromkeys(self.parts, 0.0)

    def watch(self, owner: object, method: str, name: str) -> None:
        """Time a method of an object from here on."""
        setattr(owner, method, self.timed(name, getattr(owner, method)))

    def timed(self, name: str, function: Callable) -> Callable:
        """The same function, timed."""

        def call(*args: Any, **kwargs: Any) -> Any:
            before, begun = self.inner, self.now()
            self.inner = 0.0
            try:
                return function(*args, **kwargs)
            finally:
                spent = self.now() - begun
                self.seconds[name] += spent - self.inner
                self.inner = before + spent

        return call


@dataclass(frozen=True)
class Sample:
    """Seconds of the repeats, in the order in which they were taken; under MPI of the slowest
    rank."""

    seconds: tuple[float, ...]

    @property
    def min(self) -> float:
        """The smallest."""
        return float(min(self.seconds))

    @property
    def median(self) -> float:
        """The median."""
        return float(np.median(self.seconds))


def in_turn(names: Iterable[K], repeats: int) -> Iterator[K]:
    """All names in so many rounds, every other one backwards (A B B A), so that a drift of the
    machine's speed hits all alike."""
    for k in range(repeats):
        yield from list(names)[:: 1 if k % 2 == 0 else -1]


class Clock:
    """Measures functions. cpu: by the processor's clock of this process, for a machine that others
    use too."""

    def __init__(self, comm: Comm | None = None, cpu: bool = False):
        self.comm, self.now = comm, time.process_time if cpu else time.perf_counter
        self.name = "cpu" if cpu else "wall"

    def slowest(self, seconds: float) -> float:
        """The largest of the ranks' numbers."""
        return float(self.comm.max([seconds])[0]) if self.comm is not None else float(seconds)

    def measure(self, run: Callable[[], object]) -> float:
        """Seconds of run() on the slowest rank."""
        if self.comm is not None:
            self.comm.barrier()
        begun = self.now()
        run()
        return self.slowest(self.now() - begun)

    def alternate(
        self,
        runs: Mapping[str, Callable[[], object]],
        repeats: int,
        warmup: int = 1,
        before: Callable[[], object] = lambda: None,
    ) -> dict[str, Sample]:
        """{name: Sample} of {name: function}: all in turn; not timed: rounds of warm-up, and
        `before`, which is called before each."""
        seconds: dict[str, list[float]] = {name: [] for name in runs}
        for _ in range(warmup):
            for run in runs.values():
                before()
                run()
        for name in in_turn(runs, repeats):
            before()
            seconds[name].append(self.measure(runs[name]))
        return {name: Sample(tuple(s)) for name, s in seconds.items()}


def ratio(a: Sample, b: Sample) -> float:
    """Median over the repeats of a/b: of two samples that were taken in turn."""
    return float(np.median(np.divide(a.seconds, b.seconds)))
