"""The passes of an iteration on a GPU: milliseconds, bytes, and share of the speed of a copy.

    python scripts/bench/gpu --n 4096 16384 32768 65536 --out gpu.jsonl

It needs CuPy and numba-cuda, and nothing else of this package but this folder. Every kernel is
first compared with NumPy in double precision on random data; the transforms are compared with a
plane wave at every size. A row of a kernel that is wrong says so, and the exit status is 1.
"""

import argparse
import subprocess
import sys
import time
from pathlib import Path

if not __package__:  # run by its path
    sys.path[0] = str(Path(__file__).resolve().parents[2])

import cupy as cp
import numpy as np

from bench.gpu.checks import check_levels, check_passes, check_transforms
from bench.gpu.kernel_sets import NumbaKernels, RawKernels
from bench.gpu.passes import measure_copies, measure_launch, measure_size
from bench.gpu.rows import MIB, Rows


def checked_sets(rows):
    """Return the sets of kernels that can be compiled, compared with NumPy."""
    sets = []
    for make in (RawKernels, NumbaKernels):
        try:
            begin = time.monotonic()
            kernels = make()
            check_passes(rows, kernels)
            check_transforms(rows, kernels)
            if hasattr(kernels, "smooth"):
                check_levels(rows, kernels)
            sets.append(kernels)
            rows.add("compiled", kernels=kernels.name, seconds=time.monotonic() - begin)
            measure_launch(rows, kernels)
        except Exception:
            rows.add_error("kernels", kernels=make.__name__)
    return sets


def main():
    """Measure what the command line asks for; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--n", type=int, nargs="+", default=[4096, 16384, 32768, 65536])
    parser.add_argument("--out", help="file of rows, one JSON object a line")
    parser.add_argument("--seconds", type=float, default=150.0, help="in which all must end")
    parser.add_argument("--piece", type=int, default=256, help="MiB of a piece of rows")
    arguments = parser.parse_args()
    rows = Rows(arguments.out, arguments.seconds)
    device = cp.cuda.runtime.getDeviceProperties(0)
    free, total = cp.cuda.runtime.memGetInfo()
    git = ["git", "-C", str(Path(__file__).parent), "describe", "--always", "--dirty=+"]
    commit = subprocess.run(git, capture_output=True, text=True, check=False).stdout.strip()
    versions = {"python": sys.version.split()[0], "numpy": np.__version__, "cupy": cp.__version__}
    for name in ("numba", "numba_cuda"):
        try:
            versions[name] = __import__(name).__version__
        except Exception as error:
            versions[name] = str(error)
    rows.add(
        "device",
        name=device["name"].decode(),
        multiprocessors=device["multiProcessorCount"],
        L2_MiB=device["l2CacheSize"] / MIB,
        free_GiB=round(free / 2**30, 1),
        total_GiB=round(total / 2**30, 1),
        runtime=cp.cuda.runtime.runtimeGetVersion(),
        commit=commit,
        **versions,
    )
    try:
        measure_copies(rows)
    except Exception:
        rows.add_error("copies")
    cp.get_default_memory_pool().free_all_blocks()
    sets = checked_sets(rows)
    for n in arguments.n if sets else []:
        if rows.left() < 20:
            rows.add("skipped", n=n, reason="no time left")
            continue
        try:
            measure_size(rows, n, sets, arguments.piece * MIB)
        except Exception:
            rows.add_error("size", n=n)
        cp.get_default_memory_pool().free_all_blocks()
    rows.add("end", right=not rows.is_wrong)
    return int(rows.is_wrong)


if __name__ == "__main__":
    sys.exit(main())
