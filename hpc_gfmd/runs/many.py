"""Solve many surfaces in several processes, for statistics in a notebook or a script."""

import os
import subprocess
import sys
import warnings
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence, Sized
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from queue import SimpleQueue
from typing import Any

import numpy as np

from ..parallel.launcher import LAUNCHER
from ..scene import LoadTable
from ..util.errors import GfmdError, SceneError
from ..util.machine import cores
from .progress import new_bar
from .solutions import Solutions
from .solve import Loads, solve

RESERVED = "threads", "comm"  # arguments of solve that are chosen here
BLAS = "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"
# Imports nothing of the caller's, which therefore needs no `if __name__ == "__main__"`.
PROGRAM = "import sys; sys.path[:] = {}; from hpc_gfmd.runs.many import serve; serve({})"
Outcome = tuple[Any, list[tuple[type[Warning], str]]]  # Solutions or exception, and warnings


def solve_many(
    surfaces: Iterable[Any],
    loads: Loads | None = None,
    *,
    processes: int | str = "auto",
    fields: Sequence[str] = (),
    progress: bool = False,
    **how: Any,
) -> Iterator[Solutions | Exception]:
    """Solve many surfaces, several at a time, each in a process of one thread.

    Parameters
    ----------
    surfaces : iterable
        What `solve` takes, one after another. A generator is advanced when a process is free, so
        that few surfaces are in memory at a time.
    loads : number, text with a unit, or a list of them
        Mean pressures of each surface; or another load that `solve` has, such as p_star=[0.01,
        0.1].
    processes : int, default "auto"
        Number of processes; "auto": the number of cores that this process may use.
    fields : list of names
        Fields that are kept; default: none.
    progress : bool
        Whether to draw a bar that counts the solved surfaces.
    **how
        Other arguments of `solve`.

    Returns
    -------
    iterator of Solutions
        One for each surface, in their order; in place of one that could not be solved, the
        exception that `solve` raised. Processes start with the first element and end with the last
        one.

    Raises
    ------
    SceneError
        For a single surface, an invalid number of processes, and for threads, comm or two kinds of
        load among the arguments.

    Warns
    -----
    NotConverged
        As `solve`, with the number of the surface.

    Examples
    --------
    >>> walls = (hpc_gfmd.make_surface("self-affine", seed=seed, **rough) for seed in range(200))
    >>> areas = [solutions.a_r for solutions in hpc_gfmd.solve_many(walls, p_star=[0.01, 0.1])]
    """
    is_map = getattr(surfaces, "ndim", None) == 2
    if is_map or isinstance(surfaces, str) or not isinstance(surfaces, Iterable):
        raise SceneError(
            f"surfaces: found one {type(surfaces).__name__}, allowed: several, as a list"
        )
    count = len(cores()) if processes == "auto" else processes
    if not isinstance(count, int | np.integer) or count < 1:
        raise SceneError(
            f'processes: found {processes!r}, allowed: a whole number from 1, or "auto"'
        )
    for name in RESERVED:
        if name in how:
            raise SceneError(f"{name}: found in solve_many, allowed: in solve")
    if loads is not None and how.get("pressure") is not None:
        raise SceneError("pressure: found beside loads, allowed: one of them")
    arguments = {"pressure": loads, "fields": fields} | how
    for key in arguments.keys() & LoadTable.model_fields.keys():
        if arguments[key] is not None and np.ndim(arguments[key]) == 0:
            arguments[key] = [arguments[key]]
    length = len(surfaces) if isinstance(surfaces, Sized) else None
    make_bar = partial(new_bar, "surfaces", length) if progress else nullcontext
    return _solutions(surfaces, arguments | {"threads": 1}, int(count), make_bar)


def _solutions(
    surfaces: Iterable[Any],
    arguments: dict[str, Any],
    count: int,
    make_bar: Callable[[], AbstractContextManager[Any]],
) -> Iterator[Solutions | Exception]:
    """Yield Solutions or exceptions in the order of the surfaces, from `count` processes that are
    killed when the generator is closed; their warnings are passed on.
    """
    workers = [_Worker() for _ in range(count)]
    idle: SimpleQueue[_Worker] = SimpleQueue()
    for worker in workers:
        idle.put(worker)

    def solve_one(surface: Any) -> Outcome:
        """Solve a surface by the next idle worker, for which it waits. Called in a thread."""
        worker = idle.get()
        try:
            return worker.solve(surface, arguments)
        finally:
            idle.put(worker)

    pool = ThreadPoolExecutor(count)
    pending = deque[Future]()
    submitted = 0

    def next_solution() -> Solutions | Exception:
        """Wait for the first pending surface, pass on its warnings, return its outcome."""
        number = submitted - len(pending)
        solutions, warned = pending.popleft().result()
        if bar is not None:
            bar.update()
        for category, text in warned:
            warnings.warn(f"surface {number}: {text}", category, stacklevel=3)
        return solutions

    try:
        with make_bar() as bar:
            for surface in surfaces:
                pending.append(pool.submit(solve_one, surface))
                submitted += 1
                if submitted == 1:  # it compiles the kernels, which the others then find
                    wait(pending)
                if len(pending) > 2 * count:
                    yield next_solution()
            while pending:
                yield next_solution()
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        for worker in workers:
            worker.kill()
        pool.shutdown()
        for worker in workers:  # a thread may have started one again meanwhile
            worker.kill()


class _Worker:
    """A process that solves one surface after another, and the pipe to it."""

    def __init__(self) -> None:
        self.start()

    def start(self) -> None:
        """Start the process, with a pipe to it."""
        self.connection, connection_of_process = Pipe()
        descriptor = connection_of_process.fileno()
        self.process = subprocess.Popen(
            [sys.executable, "-c", PROGRAM.format(sys.path, descriptor)],
            stdin=subprocess.DEVNULL,
            pass_fds=[descriptor],
            start_new_session=True,  # Ctrl-C reaches the calling process alone
            env=os.environ | {LAUNCHER: "none"} | dict.fromkeys(BLAS, "1"),
        )
        connection_of_process.close()

    def solve(self, surface: Any, arguments: dict[str, Any]) -> Outcome:
        """Solve a surface in the process, restarted if it died; one thread at a time."""
        if self.process.poll() is not None:
            self.start()
        try:
            self.connection.send((surface, arguments))
            return self.connection.recv()
        except (EOFError, OSError):
            code = self.process.wait()
            return GfmdError(f"the process that solved it ended with exit code {code}"), []
        except Exception as error:  # the surface cannot be pickled
            return error, []

    def kill(self) -> None:
        """Kill the process and wait for its end."""
        self.process.kill()
        self.process.wait()


def serve(descriptor: int) -> None:
    """Run in a worker: solve surfaces that arrive on a connection, send outcomes back."""
    connection = Connection(descriptor)
    while True:
        try:
            surface, arguments = connection.recv()
        except EOFError:
            return
        outcome: Any
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            try:
                outcome = solve(surface, **arguments)
            except Exception as error:
                outcome = error
        connection.send((outcome, [(warning.category, str(warning.message)) for warning in caught]))
