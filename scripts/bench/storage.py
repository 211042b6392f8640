"""Writing a field to the result file, compared with raw writes of the same bytes in the same
run."""

import os
import tempfile
from contextlib import nullcontext
from pathlib import Path

import numpy as np

from hpc_gfmd.parallel.h5 import mpi_io_obstacle, write_file
from hpc_gfmd.parallel.layout import row_starts
from hpc_gfmd.parallel.world import world

from .report import Report
from .timing import in_turn, ratio, seconds


def run(args):
    """Write single precision fields of n x n points in a temporary folder. Collective.

    All files are new and synced to the disk. "raw": every rank writes a file; "raw, one file": all
    ranks write their rows into one file.
    """
    comm = world()
    report = Report("storage", args.out, comm)
    with tempfile.TemporaryDirectory(dir=args.folder) if comm.rank == 0 else nullcontext() as name:
        folder = Path(comm.bcast(name))
        for n in args.n:
            times = _measure(comm, folder, n, args.repeats)
            for way, series in times.items():
                gb = 4e-9 * n * n
                row = {"gb": gb, "seconds": min(series), "gb_per_s": gb / min(series)}
                row["times raw"] = ratio(series, times["raw"])
                report.add(n=n, way=way, **row)
        comm.barrier()
    report.finish()


def _measure(comm, folder, n, repeats):
    """Return {way to write: seconds} for one size."""
    start, stop = row_starts(n, comm.size)[comm.rank : comm.rank + 2].tolist()
    data = np.random.default_rng(comm.rank).standard_normal((stop - start, n), dtype=np.float32)
    raw_of_rank = folder / f"raw-{comm.rank}"
    raw_shared = folder / "raw"
    result = folder / "result.h5"

    def write_raw(path, offset):
        descriptor = os.open(path, os.O_WRONLY | os.O_CREAT)
        for i in range(0, data.nbytes, 2**26):
            os.pwrite(descriptor, memoryview(data).cast("B")[i : i + 2**26], offset + i)
        os.fsync(descriptor)
        os.close(descriptor)

    write_raw(raw_shared, 4 * n * start)
    comm.barrier()
    together = not mpi_io_obstacle(comm, raw_shared)
    ways = {
        "raw": lambda: write_raw(raw_of_rank, 0),
        "raw, one file": lambda: write_raw(raw_shared, 4 * n * start),
        f"result file, {'mpio' if together else 'serial'}": lambda: write_file(
            comm, result, (n, n), (start, stop), {"field": data}, together=together
        ),
    }
    times = {way: [] for way in ways}
    for way in in_turn(ways, repeats + 1):  # the first round is a warm-up
        for path in (raw_of_rank, raw_shared, result):
            path.unlink(missing_ok=True)
        times[way].append(seconds(ways[way], comm))
    return {way: series[1:] for way, series in times.items()}
