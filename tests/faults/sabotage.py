"""Run the program with a fault in it: `python sabotage.py FAULT RANK [ARGUMENT] -- run scene.toml`.

The fault happens on one rank only (-1: on all), by replacing a function of the program; the program
itself has no hooks for this.
"""

import os
import pkgutil
import resource
import shutil
import sys
import time
from pathlib import Path


def main(fault, rank, *rest):
    """Prepare the fault, then run the command line."""
    cut = rest.index("--")
    from hpc_gfmd.parallel.world import world

    if int(rank) in (-1, world().rank):
        FAULTS[fault](*rest[:cut])
    from hpc_gfmd.commands.cli import main as program

    return program(list(rest[cut + 1 :]))


def after(function, count, then):
    """A function that is called as before, the count-th time with then(function, args) instead."""
    calls = [0]

    def called(*args, **named):
        calls[0] += 1
        if calls[0] == int(count):
            return then(lambda: function(*args, **named), args)
        return function(*args, **named)

    return called


def raised(place, name, error):
    """A fault: the count-th call of a function raises this error."""

    def fault(count=1):
        def fail(_, __):
            raise error

        owner = pkgutil.resolve_name(f"hpc_gfmd.{place}")
        setattr(owner, name, after(getattr(owner, name), count, fail))

    return fault


def nan(count, value="nan"):
    """A NaN or an infinity in the pressure of this rank, in the middle of a solve, in every
    precision."""
    from hpc_gfmd.solvers.bpx import Bpx

    def spoil(go_on, args):
        args[0].p[0, 0] = float(value)
        return go_on()

    step = Bpx.step
    spoiled = after(Bpx.step, count, spoil)
    Bpx.step = lambda self: (spoiled if self.N == 128 * 128 else step)(self)  # not on coarser grids


def limit(mebibytes):
    """So much more address space than now, once the program has begun to solve."""
    from hpc_gfmd.runs import simulation

    def shrink(go_on, _):
        with open("/proc/self/statm") as file:
            used = int(file.read().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (used + int(mebibytes) * 2**20,) * 2)
        return go_on()

    simulation.build_surface = after(simulation.build_surface, 1, shrink)


def slow(seconds):
    """Every sync to the disk takes so long: a run is mostly writing."""
    fsync = os.fsync

    def late(descriptor):
        time.sleep(float(seconds))
        fsync(descriptor)

    os.fsync = late


def hold(function, text, flag):
    """A function of parallel/h5.py, _write or sync, that does not get on when the file's name
    has this text; a file says when."""
    from hpc_gfmd.parallel import h5

    before = getattr(h5, function)

    def called(what, *args, **named):
        if not named and text in (str(what) if function == "sync" else what.file.filename):
            Path(flag).touch()
            time.sleep(60)
        return before(what, *args, **named)

    setattr(h5, function, called)


def unreserved():
    """Disk space is promised that is not there, as by file systems that cannot reserve it."""
    os.posix_fallocate = lambda *_: None


def vanish(folder):
    """A folder, when the third load is about to be written."""
    from hpc_gfmd.output.record import RunFile

    RunFile.write_step = after(
        RunFile.write_step, 3, lambda go_on, _: shutil.rmtree(folder) or go_on()
    )


def lag(seconds, flag):
    """Nothing happens for a while before the run begins to listen to signals; a file says when."""
    from hpc_gfmd.runs import simulation

    def wait(go_on, _):
        Path(f"{flag}-{os.getpid()}").touch()
        time.sleep(float(seconds))
        return go_on()

    simulation.surface_size = after(simulation.surface_size, 1, wait)


FAULTS = {fault.__name__: fault for fault in (nan, limit, slow, hold, unreserved, vanish, lag)} | {
    # while the surface is made, in the middle of a solve, of one that allocates, and while the rows
    # of this rank are written
    "surface": raised("runs.simulation", "build_surface", RuntimeError("sabotage")),
    "solve": raised("solvers.bpx:Bpx", "step", RuntimeError("sabotage")),
    "no_memory": raised("solvers.bpx:Bpx", "step", MemoryError("Unable to allocate 7.00 TiB")),
    "write": raised("parallel.h5", "_checksum", RuntimeError("sabotage")),
}

if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
