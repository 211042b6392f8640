"""Strong and weak scaling of a whole solve under mpirun, where its time goes, and what the model
makes of it on a cluster."""

from argparse import Namespace
from collections.abc import Sequence
from dataclasses import replace
from os import PathLike

import numpy as np

from hpc_gfmd.parallel.comm import stages

from .model import Machine, Network, predict
from .report import Report
from .scaling_worker import PARTS
from .workers import measured

COLUMNS = {
    "kind": ("kind", "8s"),
    "n": ("n", "6d"),
    "ranks": ("ranks", "d"),
    "threads": ("threads", "d"),
    "precision": ("precision", "s"),
    "p_star": ("p*", "6.3g"),
    "seconds": ("s", "7.3g"),
    "efficiency": ("efficiency", ".2f"),
    "fft_pairs": ("pairs", "6.1f"),
    **{f"share_{part}": (part, ".0%") for part in (*PARTS, "kernels")},
}
MODEL_COLUMNS = {
    "n": ("n", "6d"),
    "network_gb_per_s": ("link", "5.3g"),
    "nodes": ("nodes", "5d"),
    "ranks": ("ranks", "6d"),
    "threads": ("threads", "d"),
    "seconds": ("s", "7.3g"),
    "efficiency": ("efficiency", ".2f"),
    "of_one_node": ("of a node", ".2f"),
    "of_bandwidth": ("of memory", ".2f"),
    "share_transpose": ("transpose", ".0%"),
    "share_latency": ("latency", ".0%"),
    "gib_per_node": ("GiB/node", ".3g"),
}
NODES = (1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024)
# A link of 100 Gbit/s, what P3DFFT reached of such a one on 26 nodes (docs/clusters.md), and one of
# 200 Gbit/s.
NETWORKS = (Network(), Network(bandwidth=7e9), Network(bandwidth=25e9))
MESSAGES = {
    "latency": ("latency (us)", 1e6),
    "barrier": ("barrier (us)", 1e6),
    "bandwidth": ("one way (GB/s)", 1e-9),
    "halo": ("halo row (us)", 1e6),
    "sum": ("sum (us)", 1e6),
    "alltoall_bandwidth": ("all-to-all (GB/s)", 1e-9),
    "copy_bandwidth": ("copy, all cores (GB/s)", 1e-9),
}
ACCURACY = 1e-2
SMALL = 32  # points along an axis: what a solve takes there is the interpreter's


def bench_scaling(args: Namespace) -> None:
    """Measure every n on all ranks (strong), on the threads of one rank, and the smallest n grown
    with sqrt(ranks) (weak), all of a size in turn; then predict larger machines from it. args: n,
    ranks, threads, precision (lists), p_star, repeats, out."""
    report = Report("scaling", COLUMNS, args.out)
    for precision in args.precision:
        for n in args.n:
            several = [t for t in args.threads if t > 1 and 1 in args.ranks]
            rows = fastest(
                [(n, k, precision, 1) for k in args.ranks]
                + [(n, 1, precision, t) for t in several],
                args,
            )
            cores = [row["seconds"] * row["ranks"] * row["threads"] for row in rows]
            for row, spent in zip(rows, cores, strict=True):
                _add(report, "threads" if row["threads"] > 1 else "strong", row, cores[0] / spent)
        rows = fastest([(_grown(min(args.n), k), k, precision, 1) for k in args.ranks], args)
        per_pair = [
            row["seconds"] * row["ranks"] / (row["n"] ** 2 * row["fft_pairs"]) for row in rows
        ]
        for row, one in zip(rows, per_pair, strict=True):
            _add(report, "weak", row, per_pair[0] / one)
    small = fastest([(SMALL, 1, args.precision[0], 1)], args)[0]
    model = _predict(report, small, _messages(args), args.out)
    if args.out:
        from .pictures import scaling_picture

        scaling_picture(report.rows, model.rows, args.out)
        model.finish()
    report.finish()


def _grown(n: int, ranks: int) -> int:
    """The multiple of 4 nearest above n sqrt(ranks) that has small prime factors: others are slow
    to transform."""
    from scipy.fft import next_fast_len

    m = next_fast_len(round(n * ranks**0.5), real=True)
    while m % 4:
        m = next_fast_len(m + 1, real=True)
    return m


def fastest(cases: Sequence[tuple[int, int, str, int]], args: Namespace) -> list[dict]:
    """The fastest row of scaling_worker.py for each (n, ranks, precision, threads), with the median
    time; all are measured in turn.

    Raises GfmdError if one fails."""
    found = measured(
        {
            (n, ranks, threads): (
                "scaling_worker",
                ranks,
                n,
                precision,
                args.p_star,
                ACCURACY,
                threads,
            )
            for n, ranks, precision, threads in cases
        },
        args.repeats,
    )
    return [
        min(rows, key=lambda row: row["seconds"])
        | {"median_seconds": float(np.median([row["seconds"] for row in rows]))}
        for rows in found.values()
    ]


def _add(report: Report, kind: str, row: dict, efficiency: float) -> None:
    shares = {
        f"share_{name}": seconds / row["seconds"] for name, seconds in row.pop("parts").items()
    }
    report.add(kind=kind, efficiency=efficiency, **row, **shares)


def _messages(args: Namespace) -> dict[int, dict[str, float]]:
    """What numbers of ranks find of messages and memory of this machine (messages.py), the best of
    each; recorded as it is."""
    columns = {"ranks": ("ranks", "d")} | {
        name: (heading, ".3g") for name, (heading, _) in MESSAGES.items()
    }
    report = Report("messages", columns, args.out)
    found = {}
    for ranks in args.ranks:
        rows = measured({ranks: ("messages", ranks)}, args.repeats)[ranks]
        found[ranks] = {
            name: (max if "bandwidth" in name else min)(row[name] for row in rows)
            for name in MESSAGES
            if name in rows[0]
        }
        report.add(
            ranks=ranks, **{name: value * MESSAGES[name][1] for name, value in found[ranks].items()}
        )
    report.finish()
    return found


def _predict(
    report: Report, small: dict, found: dict[int, dict[str, float]], out: str | PathLike | None
) -> Report:
    """The model's rows; small: of a grid whose points take no time; found: of `_messages`."""
    model = Report("scaling-model", MODEL_COLUMNS, out)
    serial = max(
        (row for row in report.rows if row["ranks"] * row["threads"] == 1),
        key=lambda row: row["n"],
        default=None,
    )
    if serial is None:
        return model
    machine = Machine.from_row(serial, small, found[1]["copy_bandwidth"])
    model.say(f"# {machine.describe()}")
    for network in NETWORKS:
        model.say(f"# {network.describe()}")
    for row in report.rows:  # what the model makes of this machine, beside what was measured
        if row["kind"] == "strong" and row["ranks"] > 1 and row["precision"] == serial["precision"]:
            of = found[row["ranks"]]
            here = replace(
                machine,
                cores=row["ranks"],
                bandwidth=of["copy_bandwidth"],
                halo=of["halo"],
                barrier=of["barrier"] / stages(row["ranks"]),
            )
            network = Network(of["latency"], of["latency"], of["bandwidth"])
            if said := predict(row["n"], 1, here, network, row["ranks"]):
                model.say(
                    f"# this machine, n = {row['n']}, {row['ranks']} ranks: measured"
                    f" {row['seconds']:.3g} s, model {said['seconds']:.3g} s"
                )
    for network in NETWORKS:
        for n in (2**15, 2**17):
            for nodes in NODES:
                if said := predict(n, nodes, machine, network):
                    model.add(**said)
    return model
