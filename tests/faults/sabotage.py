"""Run the program with a fault in it: `python sabotage.py FAULT RANK [ARGUMENT] -- run scene.toml`.

The fault happens on one rank only (-1: on all). A function of the program is replaced for it; the
program has no hooks for faults.
"""

import os
import pkgutil
import shutil
import sys
import time
from importlib import import_module
from pathlib import Path


def main(fault, rank, *rest):
    """Prepare the fault and run the command line."""
    end = rest.index("--")
    from hpc_gfmd.parallel.world import world

    if int(rank) in (-1, world().rank):
        FAULTS[fault](*rest[:end])
    from hpc_gfmd.commands.cli import main as program

    return program(list(rest[end + 1 :]))


def after(function, count, then):
    """Return a function whose count-th call is replaced by then(function, args)."""
    calls = 0

    def counted(*args, **named):
        nonlocal calls
        calls += 1
        if calls == int(count):
            return then(lambda: function(*args, **named), args)
        return function(*args, **named)

    return counted


def raised(place, name, error):
    """Return a fault: the count-th call of a function raises an error."""

    def fault(count=1):
        def fail(_, __):
            raise error

        owner = pkgutil.resolve_name(f"hpc_gfmd.{place}")
        setattr(owner, name, after(getattr(owner, name), count, fail))

    return fault


def nan(count, value="nan"):
    """Put a nan or an infinity into the pressure of this rank in the middle of a solve."""
    from hpc_gfmd.solvers.bpx import Bpx

    def spoil(go_on, args):
        args[0].state.p[0, 0] = float(value)
        return go_on()

    step = Bpx.step
    spoiled = after(Bpx.step, count, spoil)
    Bpx.step = lambda self: (spoiled if self.N == 128 * 128 else step)(self)  # not on coarser grids


def slow(seconds):
    """Delay every sync to the disk, so that a run mostly writes."""
    fsync = os.fsync

    def late(descriptor):
        time.sleep(float(seconds))
        fsync(descriptor)

    os.fsync = late


def hold(module, function, text, flag):
    """Block a function of a module of parallel/ for files with this text in their names.

    Its arguments name the file. The file `flag` is created when it blocks. It goes on when that is
    deleted, or after a minute, and does not block again.
    """
    module = import_module(f"hpc_gfmd.parallel.{module}")
    original = getattr(module, function)
    was_held = False

    def blocking(target, *args, **named):
        nonlocal was_held
        if not named and not was_held and text in " ".join(map(str, (target, *args))):
            was_held = True
            Path(flag).touch()
            end = time.monotonic() + 60
            while Path(flag).exists() and time.monotonic() < end:
                time.sleep(0.01)
        return original(target, *args, **named)

    setattr(module, function, blocking)


def unreserved():
    """Reserve no disk space, as on file systems that cannot."""
    os.posix_fallocate = lambda *_: None
    unforeseen()


def unforeseen():
    """Find much free space on the disk, as if another program filled it up later."""
    shutil.disk_usage = lambda _: shutil._ntuple_diskusage(2**50, 0, 2**50)


FAULTS = {fault.__name__: fault for fault in (nan, slow, hold, unreserved, unforeseen)} | {
    # an error while the surface is made, in the middle of a solve, in an allocation, and while the
    # rows of this rank are written
    "surface": raised("runs.in_memory", "build_surface", RuntimeError("sabotage")),
    "solve": raised("solvers.bpx:Bpx", "step", RuntimeError("sabotage")),
    "no_memory": raised("solvers.bpx:Bpx", "step", MemoryError("Unable to allocate 7.00 TiB")),
    "write": raised("parallel.h5", "_piece", RuntimeError("sabotage")),
}

if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
