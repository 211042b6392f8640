"""Writing a field into the result file, and reading it back, against a raw write of the same bytes
in the same run."""

import os
import tempfile
from argparse import Namespace
from contextlib import nullcontext
from pathlib import Path

import numpy as np

from hpc_gfmd.parallel.comm import Comm
from hpc_gfmd.parallel.h5 import Stored, io_way, write_file
from hpc_gfmd.parallel.layout import row_starts
from hpc_gfmd.parallel.world import world

from .report import Report
from .timing import Clock, Sample, ratio

COLUMNS = {
    "n": ("n", "7d"),
    "way": ("way", "20s"),
    "gb": ("GB", "7.3g"),
    "seconds": ("s (min)", "8.3g"),
    "rate": ("GB/s", "7.3g"),
    "times_raw": ("x raw", "7.2f"),
    "times_one": ("x one file", "10.2f"),
}
ONE, READ = "raw, one file", "read back"


def bench_storage(args: Namespace) -> None:
    """Single precision fields of n x n points in a temporary folder inside args.folder; on all
    ranks. Everything is synced to the disk, into files that are not there yet: to replace one takes
    the time to free it. args: n (list), folder, repeats, out.

    raw: every rank writes a file of its own; "raw, one file": all their rows into the same one,
    which file systems let one do after the other. Both ratios are medians over rounds in which all
    take turns.
    """
    comm = world()
    report = Report("storage", COLUMNS, args.out, comm)
    clock = Clock(comm if comm.size > 1 else None)
    with tempfile.TemporaryDirectory(dir=args.folder) if comm.rank == 0 else nullcontext() as name:
        place = Path(comm.bcast(name))
        for n in args.n:
            samples = _measure(comm, clock, place, n, args.repeats)
            for way, sample in samples.items():
                gb, reading = n * n * 4 / 1e9, way == READ
                report.add(
                    n=n,
                    way=way,
                    gb=gb,
                    seconds=sample.min,
                    rate=gb / sample.min,
                    times_raw=None if reading else ratio(sample, samples["raw"]),
                    times_one=None if reading else ratio(sample, samples[ONE]),
                )
        comm.barrier()
    report.finish()


def _measure(comm: Comm, clock: Clock, place: Path, n: int, repeats: int) -> dict[str, Sample]:
    """{way: Sample} of one size; all ways in turn, every other round backwards."""
    start, stop = (int(k) for k in row_starts(n, comm.size)[comm.rank : comm.rank + 2])
    data = np.random.default_rng(comm.rank).standard_normal((stop - start, n), dtype=np.float32)
    own, one, result = place / f"raw-{comm.rank}", place / "raw", place / "result.h5"

    def write_raw(path: Path, offset: int) -> None:
        descriptor = os.open(path, os.O_WRONLY | os.O_CREAT)
        for i in range(0, data.nbytes, 2**26):
            os.pwrite(descriptor, data.reshape(-1).view("u1")[i : i + 2**26].data, offset + i)
        os.fsync(descriptor)
        os.close(descriptor)

    def write() -> dict[str, Stored]:
        return write_file(comm, result, (n, n), (start, stop), {"field": data})

    runs = {
        "raw": lambda: write_raw(own, 0),
        ONE: lambda: write_raw(one, 4 * n * start),
        f"result file, {io_way(comm)}": write,
    }

    def remove() -> None:
        for path in (own, one, result):
            path.unlink(missing_ok=True)

    samples = clock.alternate(runs, repeats, before=remove)
    stored = write()["field"]
    return samples | clock.alternate({READ: lambda: stored.slab(comm, (start, stop))}, repeats)
