"""Writing a field into the result file, and reading it back, against a raw write of the same bytes in the same run."""

import os
import tempfile
from contextlib import nullcontext
from pathlib import Path

import numpy as np

from ..parallel.comm import world
from ..parallel.fft import row_starts
from ..parallel.h5 import Slab, read_rows, sync, write_file
from .report import Report
from .timing import Clock, ratio

COLUMNS = {"n": ("n", "7d"), "way": ("way", "16s"), "gb": ("GB", "7.3g"), "seconds": ("s (min)", "8.3g"), "rate": ("GB/s", "7.3g"),
           "times_raw": ("x raw", "7.2f")}


def bench_storage(args):
    """Single precision fields of n x n points in a temporary folder inside args.folder; on all ranks. Everything is synced to the disk.
    args: n (list), folder, repeats, out."""
    comm = world()
    report = Report("storage", COLUMNS, args.out, comm)
    clock = Clock(comm if comm.size > 1 else None)
    with tempfile.TemporaryDirectory(dir=args.folder) if comm.rank == 0 else nullcontext() as name:
        place = Path(comm.bcast(name))
        for n in args.n:
            starts = row_starts(n, comm.size)
            start, stop = int(starts[comm.rank]), int(starts[comm.rank + 1])
            data = np.random.default_rng(comm.rank).standard_normal((stop - start, n), dtype=np.float32)
            field, raw = place / "field.h5", place / f"raw-{comm.rank}"

            def write_raw(data=data, raw=raw):
                data.tofile(raw)
                sync(raw)

            def write(data=data, field=field, start=start, n=n, **how):
                write_file(comm, field, {"/": {}}, {"field": Slab(data, start, (n, n))}, **how)

            samples = clock.alternate({"raw": write_raw, "result file": write}, args.repeats)
            samples["read back"] = clock.alternate({"read": lambda field=field, rows=(start, stop): read_rows(field, "field", rows)},
                                                   args.repeats)["read"]
            for way, sample in samples.items():
                gb = n * n * 4 / 1e9
                times = ratio(sample, samples["raw"]) if way == "result file" else None
                report.add(n=n, way=way, gb=gb, seconds=sample.min, rate=gb / sample.min, times_raw=times)
            if raw.exists():
                os.unlink(raw)
        comm.barrier()
    report.finish()
