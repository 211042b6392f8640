"""Writing a field into the result file against a raw write of the same bytes in the same run."""

import os
import tempfile
from contextlib import nullcontext
from pathlib import Path

import numpy as np

from hpc_gfmd.parallel.h5 import write_file
from hpc_gfmd.parallel.layout import row_starts
from hpc_gfmd.parallel.mpi_io import io_way
from hpc_gfmd.parallel.world import world

from .report import Report
from .timing import in_turn, ratio, seconds

RAW, ONE = "raw", "raw, one file"


def run(args):
    """Write single precision fields of n x n points in a temporary folder; on all ranks. args: of
    command.py.

    Everything is synced to the disk, into files that are not there yet. raw: every rank writes a
    file of its own; "raw, one file": all their rows into the same one.
    """
    comm = world()
    report = Report("storage", args.out, comm)
    with tempfile.TemporaryDirectory(dir=args.folder) if comm.rank == 0 else nullcontext() as name:
        place = Path(comm.bcast(name))
        for n in args.n:
            taken = _measure(comm, place, n, args.repeats)
            for way, spent in taken.items():
                gb = 4e-9 * n * n
                row = {"gb": gb, "seconds": min(spent), "gb_per_s": gb / min(spent)}
                row |= {f"times {raw}": ratio(spent, taken[raw]) for raw in (RAW, ONE)}
                report.add(n=n, way=way, **row)
        comm.barrier()
    report.finish()


def _measure(comm, place, n, repeats):
    """Return {way: seconds} of one size."""
    start, stop = row_starts(n, comm.size)[comm.rank : comm.rank + 2].tolist()
    data = np.random.default_rng(comm.rank).standard_normal((stop - start, n), dtype=np.float32)
    own, one, result = place / f"raw-{comm.rank}", place / "raw", place / "result.h5"

    def write_raw(path, offset):
        descriptor = os.open(path, os.O_WRONLY | os.O_CREAT)
        for i in range(0, data.nbytes, 2**26):
            os.pwrite(descriptor, memoryview(data).cast("B")[i : i + 2**26], offset + i)
        os.fsync(descriptor)
        os.close(descriptor)

    runs = {
        RAW: lambda: write_raw(own, 0),
        ONE: lambda: write_raw(one, 4 * n * start),
        f"result file, {io_way(comm, result)}": lambda: write_file(
            comm, result, (n, n), (start, stop), {"field": data}
        ),
    }
    taken = {way: [] for way in runs}
    for way in in_turn(runs, repeats + 1):  # the first round is a warm-up
        for path in (own, one, result):
            path.unlink(missing_ok=True)
        taken[way].append(seconds(runs[way], comm))
    return {way: spent[1:] for way, spent in taken.items()}
