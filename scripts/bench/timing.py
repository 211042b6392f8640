"""Comparable times of functions and processes, which take turns after a warm-up."""

import json
import os
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack, closing
from pathlib import Path

import numpy as np

from hpc_gfmd.parallel.world import world
from hpc_gfmd.util.errors import GfmdError

SCRIPTS = str(Path(__file__).resolve().parents[1])
# Seconds between two polls of an idle rank: the worker that measures needs the core.
POLL_INTERVAL = 2e-2


def in_turn(names, repeats):
    """Yield all names in each of several rounds, in the order A B, B A, A B.

    A drift of the machine's speed then affects all of them alike.
    """
    names = list(names)
    for k in range(repeats):
        yield from names if k % 2 == 0 else reversed(names)


def ratio(a, b):
    """Return the median of a/b for two series that were taken in turn."""
    return float(np.median([x / y for x, y in zip(a, b)]))


def summary(rows):
    """Return the last row with the minimum and the median of the times of all rows."""
    summarised = dict(rows[-1])
    for key in ("seconds", "cpu_seconds"):
        summarised.pop(key)
        summarised[f"{key}_min"] = min(row[key] for row in rows)
        summarised[f"{key}_median"] = float(np.median([row[key] for row in rows]))
    return summarised | {"repeats": len(rows)}


def seconds(run, comm):
    """Return the seconds that run() takes on the slowest rank. Collective."""
    comm.barrier()
    begin = time.perf_counter()
    run()
    return float(comm.max([time.perf_counter() - begin])[0])


class Stopwatch:
    """Adds up the seconds spent in methods, by name.

    The time of a watched method that is called inside another one counts for the inner one only.

    Attributes
    ----------
    clock : function
        Returns the time in seconds.
    seconds : dict of float
        Seconds by name since the last call of `take`.
    """

    def __init__(self, clock=time.perf_counter):
        self.clock = clock
        self.seconds = {}
        self._inner_seconds = 0.0

    def watch(self, owner, method, name):
        """Time a method of an object, or of all objects of a class, from now on; several methods
        can share a name."""
        function = getattr(owner, method)
        self.seconds.setdefault(name, 0.0)

        def timed(*args, **kwargs):
            outer_inner_seconds = self._inner_seconds
            begin = self.clock()
            self._inner_seconds = 0.0
            try:
                return function(*args, **kwargs)
            finally:
                elapsed = self.clock() - begin
                self.seconds[name] += elapsed - self._inner_seconds
                self._inner_seconds = outer_inner_seconds + elapsed

        setattr(owner, method, timed)

    def take(self):
        """Return the seconds by name since the last call, and start again from zero."""
        taken = self.seconds
        self.seconds = dict.fromkeys(taken, 0.0)
        return taken


class Process:
    """A program that answers each line of JSON on its input with a line of JSON.

    Parameters
    ----------
    name : str
        What error messages call it.
    command : sequence
        Program and arguments.
    **environment : str
        Additional environment variables.

    Raises
    ------
    GfmdError
        If the program cannot be started.
    """

    def __init__(self, name, command, **environment):
        self.name = name
        self._errors = tempfile.TemporaryFile("w+")  # noqa: SIM115
        try:
            self._process = subprocess.Popen(
                list(map(str, command)),
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self._errors,
                text=True,
                env=os.environ | {"OMP_NUM_THREADS": "1"} | environment,
            )
        except OSError as error:
            raise GfmdError(f"{name}: {error}") from None

    def ask(self, **question):
        """Send a question and return the answer. Raises GfmdError if the program fails."""
        try:
            print(json.dumps(question), file=self._process.stdin, flush=True)
        except OSError:  # the program has ended; its last words are read below
            pass
        line = next((line for line in self._process.stdout if line.startswith("{")), None)
        answer = json.loads(line) if line else {"error": self._last_words()}
        if "error" in answer:
            raise GfmdError(f"{self.name}: {answer['error']}")
        return answer

    def close(self):
        """Close the program's input and wait until it ends."""
        self._process.communicate()

    def _last_words(self):
        """Return the last error message of the program.

        mpirun appends advice between lines of dashes, which is left out.
        """
        self._process.wait()
        self._errors.seek(0)
        output = self._errors.read()
        message = output.partition("-----")[0].strip() or output.strip("- \n")
        return message.splitlines()[-1] if message else "the process ended without a message"


def run_workers(item, jobs, repeats, warm_ups=1):
    """Run the workers of an item (a file of this folder, see `serve`) in turn and return the rows
    of each.

    jobs: (number of ranks, arguments of the worker) by any key. The warm-ups come first and do not
    count. Raises GfmdError if a worker fails.
    """
    rows = {name: [] for name in jobs}
    with ExitStack() as stack:
        workers = {}
        for name, (ranks, arguments) in jobs.items():
            launcher = ["mpirun", "-n", ranks] if ranks > 1 else []
            command = [*launcher, sys.executable, "-m", f"bench.{item}", json.dumps(arguments)]
            process = Process(f"{item} on {ranks} ranks", command, PYTHONPATH=SCRIPTS)
            workers[name] = stack.enter_context(closing(process))
            for _ in range(warm_ups):
                process.ask()
        for name in in_turn(jobs, repeats):
            rows[name].append(workers[name].ask())
    return rows


def serve(worker):
    """Act as a worker: measure once for each line on the standard input. Collective.

    worker(comm, **arguments) prepares everything and returns a function that measures once; the
    rows that this returns are printed as JSON on rank 0.
    """
    comm = world()
    measure = worker(comm, **json.loads(sys.argv[1]))
    while _is_asked(comm):
        row = measure()
        if comm.rank == 0:
            print(json.dumps(row), flush=True)


def _is_asked(comm):
    """Wait for a line on rank 0; return False at the end of the input."""
    has_line = comm.rank == 0 and bool(sys.stdin.readline())
    if comm.size > 1:
        request = comm.mpi.Ibarrier()
        while not request.Test():
            time.sleep(POLL_INTERVAL)
    return comm.max([has_line])[0] > 0
