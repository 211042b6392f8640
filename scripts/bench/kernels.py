"""Passes of the default solver while it solves, on one core and on more: time and bytes of a point,
share of a copy's bandwidth, what a full node allows.

Bytes are those of passes.py. Cores: ranks of one solve, all at work at the same time.

The roofline of a node: a pass takes there no less than its time on one core over the number of
cores, nor than its bytes over the bandwidth of the node's memory, both as model.py assumes them.
"""

from argparse import Namespace
from collections.abc import Mapping
from typing import Any

import numpy as np

from hpc_gfmd.parallel.coarsening import levels
from hpc_gfmd.parallel.grid import Grid

from .cases import DTYPES
from .model import Machine
from .passes import COPY, field_passes
from .report import Report
from .timing import Sample, ratio
from .workers import measured

COLUMNS = {
    "n": ("n", "5d"),
    "precision": ("precision", "9"),
    "what": ("pass", "16"),
    "cores": ("cores", "d"),
    "ms_min": ("ms (min)", "9.3f"),
    "ms_median": ("ms (median)", "11.3f"),
    "bytes_per_point": ("bytes/point", "11.1f"),
    "ns_per_point": ("ns/point", "8.3f"),
    "gb_per_s": ("GB/s", "7.2f"),
    "share_of_copy": ("of copy", "7.3f"),
    "iteration_over_this": ("iteration/this", "14.3f"),
    "node_ns_per_point": ("node: ns/point", "14.4f"),
    "node_of_bandwidth": ("of its memory", "13.2f"),
}


def bench_kernels(args: Namespace) -> None:
    """One table row per pass and number of cores, and for the iteration, the copy and the bare FFT
    pairs. args: n, precision, ranks (lists), p_star, repeats, cpu, out."""
    report = Report("kernels", COLUMNS, args.out)
    report.say(
        f"# p* = {args.p_star:g}; {'cpu' if args.cpu else 'wall'} time, all numbers of cores in"
        " turn; ns/point: of all cores together; of copy: bandwidth over that of a copy on as many"
        " cores; iteration/this: median over runs in turn"
    )
    report.say(
        f"# node: at least, with {Machine.cores} cores like this one and"
        f" {Machine.bandwidth / 1e9:g} GB/s of memory"
    )
    for n in args.n:
        for precision in args.precision:
            clock = "cpu" if args.cpu else "wall"
            found = measured(
                {k: ("kernels_worker", k, n, precision, args.p_star, clock) for k in args.ranks},
                args.repeats,
            )
            for cores, rounds in found.items():
                samples = {name: Sample(tuple(row[name] for row in rounds)) for name in rounds[0]}
                _add(
                    report,
                    samples,
                    n,
                    precision,
                    cores,
                    Machine,
                    p_star=args.p_star,
                    repeats=args.repeats,
                )
    report.finish()


def _add(
    report: Report,
    samples: Mapping[str, Sample],
    n: int,
    precision: str,
    cores: int,
    node: type[Machine],
    **of_all: Any,
) -> None:
    """The rows of one grid on some cores; samples: {what: Sample}; node: its `cores` and
    `bandwidth`."""
    N, size = n * n, np.dtype(DTYPES[precision]).itemsize
    fields = field_passes([level.n for level in levels(Grid((n, n)))])
    counted = {
        name: size * f
        for name, f in (fields | {"iteration": sum(fields.values()), "copy": COPY}).items()
    }
    copy = counted["copy"] / samples["copy"].median
    for what in [*fields, *(name for name in samples if name not in fields)]:
        sample, nbytes = samples[what], counted.get(what)
        row = {
            "n": n,
            "precision": precision,
            "what": what,
            "cores": cores,
            "ms_min": 1e3 * sample.min,
            "ms_median": 1e3 * sample.median,
            "ns_per_point": 1e9 * sample.min / N,
            "iteration_over_this": ratio(samples["iteration"], sample),
        }
        if nbytes:
            row |= {
                "bytes_per_point": nbytes,
                "gb_per_s": 1e-9 * N * nbytes / sample.min,
                "share_of_copy": nbytes / sample.median / copy,
            }
        if nbytes and cores == 1:
            least, memory = sample.min / N / node.cores, nbytes / node.bandwidth
            row |= {
                "node_ns_per_point": 1e9 * max(least, memory),
                "node_of_bandwidth": memory / max(least, memory),
            }
        report.add(**row, **of_all)
