"""Many surfaces, each solved by one of several processes, for statistics in a notebook or a
script."""

import os
import subprocess
import sys
import warnings
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, wait
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from queue import SimpleQueue
from typing import Any

import numpy as np

from ..parallel.launcher import LAUNCHER
from ..scene import Load
from ..util.errors import GfmdError, SceneError
from ..util.machine import cores
from .solution import Solutions
from .solve import Loads, solve

OURS = "threads", "comm", "progress"  # arguments of solve that are not the caller's
BLAS = "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"
# What a process runs: nothing of the caller's program, which needs no `if __name__ == "__main__"`.
PROGRAM = "import sys; sys.path[:] = {}; from hpc_gfmd.runs.many import serve; serve({})"


def solve_many(
    surfaces: Iterable[Any],
    loads: Loads | None = None,
    *,
    processes: int | str = "auto",
    fields: Sequence[str] = (),
    **how: Any,
) -> Iterator[Solutions | Exception]:
    """Press many surfaces, several at a time: each in one of several processes of one thread.

    Parameters
    ----------
    surfaces : iterable
        What `solve` takes, one after another. A generator makes them when there is a process for
        them: few are in memory at a time.
    loads : number, text with a unit, or a list of them
        Mean pressures of each surface; or another load that `solve` has, such as p_star=[0.01,
        0.1].
    processes : int, default "auto"
        The cores that this process may use.
    fields : list of names
        Fields that are kept; default: none.
    **how
        Other arguments of `solve`.

    Returns
    -------
    iterator of Solutions
        One for each surface, in their order; in place of one that could not be solved the exception
        that `solve` raised.

    Raises
    ------
    SceneError
        For a number of processes that makes no sense.

    Warns
    -----
    NotConverged
        As `solve`, with the number of the surface.

    Examples
    --------
    >>> walls = (hpc_gfmd.make_surface("self-affine", seed=seed, **rough) for seed in range(200))
    >>> areas = [found.values("a_r") for found in hpc_gfmd.solve_many(walls, p_star=[0.01, 0.1])]
    """
    count = len(cores()) if processes == "auto" else processes
    if not isinstance(count, int | np.integer) or count < 1:
        raise SceneError(
            f'processes: found {processes!r}, allowed: a whole number from 1, or "auto"'
        )
    for name in OURS:
        if name in how:
            raise SceneError(f"{name}: found in solve_many, allowed: in solve")
    if loads is not None and how.get("pressure") is not None:
        raise SceneError("pressure: found beside loads, allowed: one of them")
    given = {"pressure": loads, "fields": fields} | how
    for key in given.keys() & Load.model_fields.keys():
        if given[key] is not None and np.ndim(given[key]) == 0:
            given[key] = [given[key]]
    return _each(surfaces, given | {"threads": 1}, int(count))


def _each(
    surfaces: Iterable[Any], how: dict[str, Any], count: int
) -> Iterator[Solutions | Exception]:
    free: SimpleQueue[_Worker] = SimpleQueue()
    workers = [_Worker() for _ in range(count)]
    for worker in workers:
        free.put(worker)

    def ask(surface: Any) -> tuple[Any, list]:
        worker = free.get()
        try:
            return worker.ask((surface, how))
        finally:
            free.put(worker)

    def result(number: int) -> Solutions | Exception:
        found, warned = waiting.popleft().result()
        for kind, text in warned:
            warnings.warn(f"surface {number}: {text}", kind, stacklevel=3)
        return found

    pool, waiting = ThreadPoolExecutor(count), deque[Future]()
    try:
        asked = 0
        for asked, surface in enumerate(surfaces, 1):
            waiting.append(pool.submit(ask, surface))
            if asked == 1:  # it compiles what the others will find
                wait(waiting)
            if len(waiting) > 2 * count:
                yield result(asked - len(waiting))
        while waiting:
            yield result(asked - len(waiting))
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        for worker in workers:
            worker.end()
        pool.shutdown()
        for worker in workers:  # one that was begun meanwhile
            worker.end()


class _Worker:
    """A process that solves what it is asked to; begun anew where it has died."""

    def __init__(self) -> None:
        self.begin()

    def begin(self) -> None:
        self.connection, there = Pipe()
        self.process = subprocess.Popen(
            [sys.executable, "-c", PROGRAM.format(sys.path, there.fileno())],
            stdin=subprocess.DEVNULL,
            pass_fds=[there.fileno()],
            start_new_session=True,  # Ctrl-C is for this process alone
            env=os.environ | {LAUNCHER: "none"} | dict.fromkeys(BLAS, "1"),
        )
        there.close()

    def ask(self, task: tuple) -> tuple[Any, list]:
        """Have a task done; return the Solutions, or what was raised, and the warnings: (kind,
        text) of each."""
        if self.process.poll() is not None:
            self.begin()
        try:
            self.connection.send(task)
            return self.connection.recv()
        except (EOFError, OSError):
            code = self.process.wait()
            return GfmdError(f"the process that solved it has ended ({code})"), []
        except Exception as error:  # what cannot be sent
            return error, []

    def end(self) -> None:
        self.process.kill()
        self.process.wait()


def serve(descriptor: int) -> None:
    """Solve what is asked for, until the other end is closed."""
    connection = Connection(descriptor)
    while True:
        try:
            surface, how = connection.recv()
        except EOFError:
            return
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            found: Any
            try:
                found = solve(surface, **how)
            except Exception as error:
                found = error
        connection.send((found, [(one.category, str(one.message)) for one in caught]))
