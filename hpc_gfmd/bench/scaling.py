"""Strong and weak scaling of a whole solve under mpirun, where its time goes, and what the model makes of it on a cluster."""

import json
import os
import subprocess
import sys
from dataclasses import replace

from ..errors import GfmdError
from .model import Machine, Network, predict
from .report import Report
from .scaling_picture import scaling_picture
from .scaling_worker import PARTS

COLUMNS = {"kind": ("kind", "8s"), "n": ("n", "6d"), "ranks": ("ranks", "d"), "threads": ("threads", "d"),
           "precision": ("precision", "s"), "p_star": ("p*", "6.3g"),
           "seconds": ("s", "7.3g"), "efficiency": ("efficiency", ".2f"), "fft_pairs": ("pairs", "6.1f"),
           **{f"share_{part}": (part, ".0%") for part in (*PARTS, "kernels")}}
MODEL_COLUMNS = {"n": ("n", "6d"), "network_gb_per_s": ("link", "5.3g"), "nodes": ("nodes", "5d"), "ranks": ("ranks", "6d"),
                 "threads": ("threads", "d"), "seconds": ("s", "7.3g"), "efficiency": ("efficiency", ".2f"),
                 "of_one_node": ("of a node", ".2f"), "of_bandwidth": ("of memory", ".2f"),
                 "share_transpose": ("transpose", ".0%"), "share_latency": ("latency", ".0%"),
                 "gib_per_node": ("GiB/node", ".3g")}
NODES = (1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024)
NETWORKS = (Network(), Network(bandwidth=25e9))
HERE = 1e12  # bytes per second: two cores do not use up the memory of this machine
ACCURACY = 1e-2


def bench_scaling(args):
    """Measure every n on all ranks (strong), on the threads of one rank, and the smallest n grown with sqrt(ranks) (weak); then predict
    larger machines from it. args: n, ranks, threads, precision (lists), p_star, repeats, out."""
    report = Report("scaling", COLUMNS, args.out)
    alone = {}
    for precision in args.precision:
        for n in args.n:
            for k in args.ranks:
                row = measure(n, k, precision, args.p_star, args.repeats)
                alone.setdefault((n, precision), (row["seconds"] * k, k))
                best = alone[n, precision][0]
                _add(report, "strong", row, best / (row["seconds"] * k))
            for t in (t for t in args.threads if t > 1 and 1 in args.ranks):
                row = measure(n, 1, precision, args.p_star, args.repeats, t)
                _add(report, "threads", row, alone[n, precision][0] / (row["seconds"] * t))
        n = min(args.n)
        first = None
        for k in args.ranks:
            grown = _grown(n, k)
            row = measure(grown, k, precision, args.p_star, args.repeats)
            per_point = row["seconds"] * k / (grown * grown)
            first = first or per_point
            _add(report, "weak", row, first / per_point)
    model = _predict(report, args.out)
    if args.out:
        scaling_picture(report.rows, model.rows, args.out)
        model.finish()
    report.finish()


def _grown(n, ranks):
    """The multiple of 4 nearest above n sqrt(ranks) that has small prime factors: others are slow to transform."""
    from scipy.fft import next_fast_len

    m = next_fast_len(round(n * ranks**0.5), real=True)
    while m % 4:
        m = next_fast_len(m + 1, real=True)
    return m


def measure(n, ranks, precision, p_star, repeats, threads=1):
    """One row of scaling_worker.py on a number of ranks. Raises GfmdError if it fails."""
    worker = [sys.executable, "-m", "hpc_gfmd.bench.scaling_worker", str(n), precision, str(p_star), str(ACCURACY), str(repeats),
              str(threads)]
    command = worker if ranks == 1 else ["mpirun", "-n", str(ranks), *worker]
    done = subprocess.run(command, capture_output=True, text=True, env=os.environ | {"OMP_NUM_THREADS": "1"})
    if done.returncode != 0:
        said = [line for line in done.stderr.splitlines() if any(map(str.isalpha, line))]  # not the frame around an mpirun's words
        raise GfmdError(f"scaling on {ranks} ranks failed: {said[-1].strip() if said else '?'}")
    return json.loads(done.stdout.strip().splitlines()[-1])


def _add(report, kind, row, efficiency):
    shares = {f"share_{name}": seconds / row["seconds"] for name, seconds in row.pop("parts").items()}
    report.add(kind=kind, efficiency=efficiency, **row, **shares)


def _predict(report, out):
    model = Report("scaling-model", MODEL_COLUMNS, out)
    serial = max((row for row in report.rows if row["ranks"] == 1), key=lambda row: row["n"], default=None)
    if serial is None:
        return model
    machine = Machine.from_row(serial)
    model.say(f"# {machine.describe()}")
    for network in NETWORKS:
        model.say(f"# {network.describe()}")
    for row in report.rows:  # what the model makes of this machine, beside what was measured
        if row["kind"] == "strong" and row["ranks"] > 1 and row["precision"] == serial["precision"]:
            here = replace(machine, cores=row["ranks"], bandwidth=HERE)
            said = predict(row["n"], 1, here, NETWORKS[0], row["ranks"])["seconds"]
            model.say(f"# n = {row['n']}, {row['ranks']} ranks: measured {row['seconds']:.3g} s, model {said:.3g} s")
    for network in NETWORKS:
        for n in (2**15, 2**17):
            for nodes in NODES:
                row = predict(n, nodes, machine, network)
                if row:
                    model.add(**row)
    return model
