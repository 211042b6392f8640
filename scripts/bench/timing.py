"""Times that can be compared: of functions and processes that take turns, after a warm-up."""

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
# seconds between two looks of a rank that waits: those that measure need the core that it takes
PAUSE = 2e-2


def in_turn(names, repeats):
    """Yield all names in so many rounds, every other one backwards (A B B A), so that a drift of
    the machine's speed hits all alike."""
    for k in range(repeats):
        yield from list(names)[:: 1 if k % 2 == 0 else -1]


def ratio(a, b):
    """Return the median of a/b, of two series that were taken in turn."""
    return float(np.median([x / y for x, y in zip(a, b)]))


def summary(rows):
    """Return the last row with the times of all in place of its own."""
    found = dict(rows[-1])
    for key in ("seconds", "cpu_seconds"):
        found.pop(key)
        found[f"{key}_min"] = min(row[key] for row in rows)
        found[f"{key}_median"] = float(np.median([row[key] for row in rows]))
    return found | {"repeats": len(rows)}


def seconds(run, comm, now=time.perf_counter):
    """Return the seconds of run() on the slowest rank, by the clock `now`."""
    comm.barrier()
    begun = now()
    run()
    return float(comm.max([now() - begun])[0])


class Stopwatch:
    """Adds up seconds by name, by the clock `now`; time of inner parts is not counted in outer
    ones."""

    def __init__(self, now=time.perf_counter):
        self.now, self.inner = now, 0.0
        self.seconds = {}

    def watch(self, owner, method, name):
        """Time a method of an object or of all objects of a class from here on."""
        function = getattr(owner, method)
        self.seconds.setdefault(name, 0.0)

        def timed(*args, **kwargs):
            before, begun = self.inner, self.now()
            self.inner = 0.0
            try:
                return function(*args, **kwargs)
            finally:
                spent = self.now() - begun
                self.seconds[name] += spent - self.inner
                self.inner = before + spent

        setattr(owner, method, timed)

    def take(self):
        """Return the seconds since the last time."""
        found, self.seconds = self.seconds, dict.fromkeys(self.seconds, 0.0)
        return found


class Process:
    """A program that answers each line of JSON with one. Raises GfmdError where it fails."""

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

    def ask(self, **what):
        """Return the answer."""
        try:
            print(json.dumps(what), file=self._process.stdin, flush=True)
        except OSError:  # it has ended: how, will be found
            pass
        line = next((line for line in self._process.stdout if line.startswith("{")), None)
        answer = json.loads(line) if line else {"error": self._last_words()}
        if "error" in answer:
            raise GfmdError(f"{self.name}: {answer['error']}")
        return answer

    def close(self):
        """Let it end."""
        self._process.communicate()

    def _last_words(self):
        """Return the end of what the program itself says: mpirun adds advice between lines of
        dashes."""
        self._process.wait()
        self._errors.seek(0)
        said = self._errors.read()
        own = said.partition("-----")[0].strip() or said.strip("- \n")
        return own.splitlines()[-1] if own else "it died without a word"


def measured(item, jobs, repeats, warm=1):
    """Return what worker(**arguments) of a file here finds on some ranks, so many times, all in
    turn; jobs: (ranks, arguments) of each; warm: times before. Raises GfmdError."""
    found = {name: [] for name in jobs}
    with ExitStack() as stack:
        workers = {}
        for name, (ranks, arguments) in jobs.items():
            launcher = ["mpirun", "-n", ranks] if ranks > 1 else []
            command = [*launcher, sys.executable, "-m", f"bench.{item}", json.dumps(arguments)]
            process = Process(f"{item} on {ranks} ranks", command, PYTHONPATH=SCRIPTS)
            workers[name] = stack.enter_context(closing(process))
            for _ in range(warm):
                process.ask()
        for name in in_turn(jobs, repeats):
            found[name].append(workers[name].ask())
    return found


def serve(worker):
    """Be such a worker: print what worker(comm, **arguments)() returns on rank 0, as often as asked
    on standard input. Collective."""
    comm = world()
    measure = worker(comm, **json.loads(sys.argv[1]))
    while _asked(comm):
        row = measure()
        if comm.rank == 0:
            print(json.dumps(row), flush=True)


def _asked(comm):
    more = comm.rank == 0 and bool(sys.stdin.readline())
    if comm.size > 1:
        met = comm.mpi.Ibarrier()
        while not met.Test():
            time.sleep(PAUSE)
    return comm.max([more])[0] > 0
