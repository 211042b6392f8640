"""Solve walls, write rows of JSON and print a table.

python scripts/campaign --count 5 --jobs 2 --out rows.jsonl --record docs/campaign.jsonl
python scripts/campaign --family wave --seed 1 --index 3 --precision single --accuracy 1e-2
python scripts/campaign --report rows.jsonl
"""

import argparse
import json
import shlex
import sys
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from itertools import product
from multiprocessing import get_context

PRECISIONS = ("auto", "single", "double")
ACCURACIES = (1e-2, 1e-3, 1e-4, 1e-6)
SINGLE_FINEST = 1e-4  # tightest accuracy that is requested in single precision


def ways(solvers, precisions, accuracies, low_memory):
    """Return (solver, precision, accuracy, low_memory) of all solves of a wall; the argument
    low_memory is "yes", "no" or "only"."""
    plain = [
        (s, p, e, False)
        for s, p, e in product(solvers, precisions, accuracies)
        if p != "single" or e >= SINGLE_FINEST
    ]
    low = [(s, p, e, True) for s, p, e, _ in plain if s == "bpx"]
    return {"yes": plain + low, "no": plain, "only": low}[low_memory]


def make_parser():
    """Return the parser of the campaign."""
    parser = argparse.ArgumentParser(
        prog="campaign",
        description="Solve walls for which the code was not tuned, and compare with exact"
        " solutions.",
    )
    add = parser.add_argument
    add(
        "--families",
        "--family",
        nargs="+",
        default=["all"],
        help="names, or all, single, free, sweeps, targets",
    )
    add("--without", nargs="+", default=[])
    add("--count", type=int, default=5, help="walls of each family")
    add("--seed", type=int, default=1)
    add(
        "--index",
        type=int,
        nargs="+",
        help="numbers of the walls of each family, instead of the first --count",
    )
    add("--solvers", nargs="+", default=["bpx"], choices=("bpx", "gfmd"))
    add("--precision", nargs="+", default=list(PRECISIONS), choices=PRECISIONS)
    add("--accuracy", nargs="+", type=float, default=list(ACCURACIES))
    add("--low-memory", default="yes", choices=("yes", "no", "only"))
    add("--jobs", type=int, default=1)
    add("--seconds", type=float, default=1e9, help="start no further wall after this time")
    add("--out", help="append the rows of all solves to this file")
    add("--record", help="append the counts, as one line of JSON, to this file")
    add("--report", nargs="+", help="only print the table of these files of rows")
    add("--records", nargs="+", help="only print the table of these files of counts")
    add("--worst", type=int, default=40, help="failures in the report")
    return parser


def main(args):
    """Run the campaign, print its table and record its counts."""
    from bench.report import provenance

    from hpc_gfmd.parallel.comm import SerialComm

    from .table import count, grouped, markdown, read, report

    if args.records:
        records = [row for path in args.records for row in read(path)]
        print(markdown({row["command"]: row for row in records}, "command"))
        return
    rows = [row for path in args.report or () for row in read(path)]
    for new_rows in [] if args.report else campaign(args):
        rows += new_rows
        if args.out:
            with open(args.out, "a") as file:
                file.writelines(json.dumps(row, default=float) + "\n" for row in new_rows)
    print(report(rows, args.worst))
    if args.record:
        command = shlex.join(["scripts/campaign", *sys.argv[1:]])
        commit = provenance(SerialComm())["commit"]
        record = {"command": command, "commit": commit}
        record |= count(rows) | {"families": grouped(rows)}
        with open(args.record, "a") as file:
            file.write(json.dumps(record) + "\n")


def names(requested, without=()):
    """Return the names of the requested families and groups: all, single (periodic, one load each),
    free (with free edges), sweeps, targets (prescribed areas and gaps)."""
    from .families import FAMILIES

    groups = {"all": list(FAMILIES), "single": [], "free": [], "sweeps": [], "targets": []}
    for name in FAMILIES:
        kinds = {"free": "free", "sweep": "sweeps", "target": "targets"}
        kind = kinds.get(name.partition("_")[0], "single")
        groups[kind].append(name)
    chosen = [
        name for item in requested for name in groups.get(item, [item]) if name not in without
    ]
    unknown = [name for name in chosen if name not in FAMILIES]
    if unknown:
        sys.exit(f"--families: found {unknown}, allowed: {', '.join([*groups, *FAMILIES])}")
    return chosen


def campaign(args):
    """Yield the rows of each wall when it is solved; args are those of the command line."""
    all_ways = ways(args.solvers, args.precision, args.accuracy, args.low_memory)
    end = time.monotonic() + args.seconds
    walls = product(args.index or range(args.count), names(args.families, args.without))
    tasks = [(name, args.seed, index, all_ways) for index, name in walls]
    if args.jobs == 1:
        yield from (_task(task, end) for task in tasks)
        return
    with ProcessPoolExecutor(args.jobs, mp_context=get_context("spawn")) as pool:
        futures = [pool.submit(_task, task, end) for task in tasks]
        for future in as_completed(futures):
            yield future.result()


def _task(task, end):
    from .solving import rows_of

    return rows_of(*task) if time.monotonic() < end else []
