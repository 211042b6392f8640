"""Processes that measure when they are told to: several can take turns, so that a drift of the
machine's speed hits all alike."""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

from hpc_gfmd.parallel.comm import Comm
from hpc_gfmd.util.errors import GfmdError

from .timing import K, in_turn

# seconds between two looks of a rank that waits: those that measure wait for the one whose core it
# takes
PAUSE = 2e-2
SCRIPTS = str(Path(__file__).parents[1])


class Worker:
    """A module of this package on a number of ranks, which calls `serve`. Raises GfmdError if it
    fails."""

    def __init__(self, module: str, ranks: int, *args: object):
        command = [sys.executable, "-m", f"bench.{module}", *map(str, args)]
        if ranks > 1:
            command = ["mpirun", "-n", str(ranks), *command]
        self.what = f"{module} on {ranks} rank{'s' * (ranks > 1)}"
        self._errors = tempfile.TemporaryFile("w+")  # noqa: SIM115
        try:
            self._process: Any = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self._errors,
                text=True,
                env=os.environ | {"OMP_NUM_THREADS": "1", "PYTHONPATH": SCRIPTS},
            )
        except OSError as error:
            raise GfmdError(f"{self.what}: {error}") from None
        self._answer()  # ready

    def measure(self) -> dict[str, Any]:
        """What the worker found, once more."""
        try:
            self._process.stdin.write("again\n")
            self._process.stdin.flush()
        except OSError:  # it has ended: how, will be found
            pass
        return self._answer()

    def close(self) -> None:
        """Let it end."""
        self._process.communicate()

    def _answer(self) -> dict[str, Any]:
        for line in self._process.stdout:
            if line.startswith("{"):
                return json.loads(line)
        self._process.wait()
        self._errors.seek(0)
        raise GfmdError(f"{self.what} failed: {what_failed(self._errors.read())}")


def measured(jobs: Mapping[K, Sequence], repeats: int) -> dict[K, list[dict[str, Any]]]:
    """All that workers find who take turns so many times; jobs: what each Worker is made of. Raises
    GfmdError if one fails."""
    found: dict[K, list] = {name: [] for name in jobs}
    with ExitStack() as stack:
        workers = {name: stack.enter_context(closing(Worker(*job))) for name, job in jobs.items()}
        for name in in_turn(jobs, repeats):
            found[name].append(workers[name].measure())
    return found


def what_failed(text: str) -> str:
    """The line of standard error that says most: the last one of ours, or else the first one of
    mpirun's, which dashes frame."""
    lines = [line.strip() for line in text.splitlines()]
    frame = next((k for k, line in enumerate(lines) if line.startswith("-----")), len(lines))
    ours, launchers = (
        [line for line in part if any(map(str.isalpha, line))]
        for part in (lines[:frame], lines[frame:])
    )
    return ours[-1] if ours else launchers[0] if launchers else "?"


def serve(comm: Comm, measure: Callable[[], dict]) -> None:
    """Print what measure() returns, a dict, on rank 0, as often as asked on its standard input.
    Collective."""
    _say(comm, {})
    while _asked(comm):
        _say(comm, measure())


def _say(comm: Comm, row: dict) -> None:
    if comm.rank == 0:
        print(json.dumps(row), flush=True)


def _asked(comm: Comm) -> bool:
    more = comm.rank == 0 and bool(sys.stdin.readline())
    if comm.mpi is not None:
        met = comm.mpi.Ibarrier()
        while not met.Test():
            time.sleep(PAUSE)
    return comm.max([more])[0] > 0
