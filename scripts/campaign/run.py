"""Solve, write rows of JSON, print the table.

python scripts/campaign --count 5 --jobs 2 --out rows.jsonl
python scripts/campaign --family wave --seed 1 --index 3 --precision single --accuracy 1e-2
python scripts/campaign --report rows.jsonl
"""

import argparse
import json
import os
import sys
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from itertools import product
from multiprocessing import get_context

SOLVERS = ("bpx", "gfmd", "fire", "ccg")
PRECISIONS = ("auto", "single", "double")
ACCURACIES = (1e-2, 1e-3, 1e-4, 1e-6)
SINGLE_FINEST = 1e-4  # the finest accuracy that is asked for in single precision


def ways(solvers, precisions, accuracies, low_memory):
    """(solver, precision, accuracy, low_memory) of all solves of a wall. low_memory: "yes", "no" or
    "only"."""
    plain = [
        (s, p, e, False)
        for s, p, e in product(solvers, precisions, accuracies)
        if p != "single" or e >= SINGLE_FINEST
    ]
    low = [(s, p, e, True) for s, p, e, _ in plain if s == "bpx"]
    return {"yes": plain + low, "no": plain, "only": low}[low_memory]


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="campaign", description=__doc__.splitlines()[0])
    parser.add_argument(
        "--families",
        "--family",
        nargs="+",
        default=["all"],
        help="names, or all, single, free, sweeps",
    )
    parser.add_argument("--without", nargs="+", default=[])
    parser.add_argument("--count", type=int, default=5, help="walls of each family")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--index",
        type=int,
        nargs="+",
        help="these walls of each family instead of the first --count",
    )
    parser.add_argument("--solvers", nargs="+", default=["bpx"], choices=SOLVERS)
    parser.add_argument("--precision", nargs="+", default=list(PRECISIONS), choices=PRECISIONS)
    parser.add_argument("--accuracy", nargs="+", type=float, default=list(ACCURACIES))
    parser.add_argument("--low-memory", default="yes", choices=("yes", "no", "only"))
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument(
        "--seconds", type=float, default=1e9, help="begin no further wall after this time"
    )
    parser.add_argument("--out", help="rows are added to this file")
    parser.add_argument("--report", nargs="+", help="print the table of these files instead")
    parser.add_argument("--worst", type=int, default=40)
    given = parser.parse_args(arguments)
    os.environ["OMP_NUM_THREADS"] = "1"
    from .table import read, report

    if given.report:
        print(report([row for path in given.report for row in read(path)], given.worst))
        return
    rows = []
    for new in campaign(
        names(given.families, given.without),
        given.index or range(given.count),
        given.seed,
        ways(given.solvers, given.precision, given.accuracy, given.low_memory),
        given.jobs,
        given.seconds,
    ):
        rows += new
        if given.out:
            with open(given.out, "a") as file:
                file.writelines(json.dumps(row) + "\n" for row in new)
    print(report(rows, given.worst))


def names(wanted, without=()):
    """Names of families: of `all`, `single` (periodic, one load each), `free` (with free edges),
    `sweeps`, or themselves."""
    from .families import FAMILIES
    from .sweeps import SINGLE

    free = [name for name in FAMILIES if name.startswith("free_")]
    groups = {
        "all": list(FAMILIES),
        "single": list(SINGLE),
        "free": free,
        "sweeps": [name for name in FAMILIES if name not in SINGLE and name not in free],
    }
    found = [name for item in wanted for name in groups.get(item, [item]) if name not in without]
    unknown = [name for name in found if name not in FAMILIES]
    if unknown:
        sys.exit(
            f"unknown families {unknown}, known: all, single, free, sweeps, {', '.join(FAMILIES)}"
        )
    return found


def campaign(families, indices, seed, all_ways, jobs=1, seconds=1e9):
    """Rows of wall after wall, as they come."""
    from .solving import rows_of

    end, tasks = (
        time.monotonic() + seconds,
        [(name, seed, index, all_ways) for index in indices for name in families],
    )
    if jobs == 1:
        for task in tasks:
            if time.monotonic() < end:
                yield rows_of(*task)
        return
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        futures = [pool.submit(_task, task, end) for task in tasks]
        for k, future in enumerate(as_completed(futures)):
            yield future.result()
            if k % 50 == 49:
                print(f"{k + 1} of {len(futures)} walls", file=sys.stderr, flush=True)


def _task(task, end):
    from .solving import rows_of

    return rows_of(*task) if time.monotonic() < end else []
