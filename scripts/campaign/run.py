"""Solve, write rows of JSON, print the table.

python scripts/campaign --count 5 --jobs 2 --out rows.jsonl --record docs/campaign.jsonl
python scripts/campaign --family wave --seed 1 --index 3 --precision single --accuracy 1e-2
python scripts/campaign --report rows.jsonl
python scripts/campaign calibrate
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
SINGLE_FINEST = 1e-4  # the finest accuracy that is asked for in single precision


def ways(solvers, precisions, accuracies, low_memory):
    """List (solver, precision, accuracy, low_memory) of all solves of a wall. low_memory: "yes",
    "no" or "only"."""
    plain = [
        (s, p, e, False)
        for s, p, e in product(solvers, precisions, accuracies)
        if p != "single" or e >= SINGLE_FINEST
    ]
    low = [(s, p, e, True) for s, p, e, _ in plain if s == "bpx"]
    return {"yes": plain + low, "no": plain, "only": low}[low_memory]


def parser():
    """Make the parser of the campaign and of `calibrate`."""
    found = argparse.ArgumentParser(
        prog="campaign",
        description="Press walls that nobody tuned to, and compare with exact solutions.",
    )
    add = found.add_argument
    add("what", nargs="?", default="run", choices=("run", "calibrate"))
    add(
        "--families",
        "--family",
        nargs="+",
        default=["all"],
        help="or all, single, free, sweeps, targets",
    )
    add("--without", nargs="+", default=[])
    add("--count", type=int, default=5, help="walls of each family")
    add("--seed", type=int, default=1)
    add("--index", type=int, nargs="+", help="these walls of each family, not the first --count")
    add("--solvers", nargs="+", default=["bpx"], choices=("bpx", "gfmd"))
    add("--precision", nargs="+", default=list(PRECISIONS), choices=PRECISIONS)
    add("--accuracy", nargs="+", type=float, default=list(ACCURACIES))
    add("--low-memory", default="yes", choices=("yes", "no", "only"))
    add("--jobs", type=int, default=1)
    add("--seconds", type=float, default=1e9, help="begin no further wall after this time")
    add("--out", help="the rows of all solves are added to this file")
    add("--record", help="the counts, as one line of JSON, are added to this file")
    add("--report", nargs="+", help="print the table of these files of rows instead")
    add("--records", nargs="+", help="print a table of these files of counts instead")
    add("--numbers", nargs="+", help="calibrate: these alone")
    add("--worst", type=int, default=40)
    return found


def main(given):
    """Run the campaign with these arguments, print what came out, and record it."""
    from bench.report import provenance

    from hpc_gfmd.parallel.comm import SerialComm

    from .table import count, grouped, markdown, read, report

    if given.records:
        records = [row for path in given.records for row in read(path)]
        print(markdown({row["command"]: row for row in records}, "command"))
        return
    rows = [row for path in given.report or () for row in read(path)]
    for new in [] if given.report else campaign(given):
        rows += new
        if given.out:
            with open(given.out, "a") as file:
                file.writelines(json.dumps(row, default=float) + "\n" for row in new)
    print(report(rows, given.worst))
    if given.record:
        command = shlex.join(["scripts/campaign", *sys.argv[1:]])
        commit = provenance(SerialComm())["commit"]
        found = {"command": command, "commit": commit}
        with open(given.record, "a") as file:
            file.write(json.dumps(found | count(rows) | {"families": grouped(rows)}) + "\n")


def names(wanted, without=()):
    """List names of families: those of `all`, `single` (periodic, one load each), `free` (with free
    edges), `sweeps`, `targets` (prescribed areas and gaps), or single ones."""
    from .families import FAMILIES

    groups = {"all": list(FAMILIES), "single": [], "free": [], "sweeps": [], "targets": []}
    for name in FAMILIES:
        kinds = {"free": "free", "sweep": "sweeps", "target": "targets"}
        kind = kinds.get(name.partition("_")[0], "single")
        groups[kind].append(name)
    found = [name for item in wanted for name in groups.get(item, [item]) if name not in without]
    unknown = [name for name in found if name not in FAMILIES]
    if unknown:
        sys.exit(f"unknown families {unknown}, known: {', '.join([*groups, *FAMILIES])}")
    return found


def campaign(given):
    """Yield the rows of wall after wall, as they come; given: arguments of the command line."""
    all_ways = ways(given.solvers, given.precision, given.accuracy, given.low_memory)
    end = time.monotonic() + given.seconds
    walls = product(given.index or range(given.count), names(given.families, given.without))
    tasks = [(name, given.seed, index, all_ways) for index, name in walls]
    if given.jobs == 1:
        yield from (_task(task, end) for task in tasks)
        return
    with ProcessPoolExecutor(given.jobs, mp_context=get_context("spawn")) as pool:
        futures = [pool.submit(_task, task, end) for task in tasks]
        for future in as_completed(futures):
            yield future.result()


def _task(task, end):
    from .solving import rows_of

    return rows_of(*task) if time.monotonic() < end else []
