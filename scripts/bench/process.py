"""A solve in one process, as in a notebook.

Measured are the first solve, the following ones on the same surface, the same on threads, and the
share of the time that is spent outside of the solver's passes.

Cores share memory and caches, so that each is slower while others work. `slower_on_threads` is the
processor time of a solve on several threads over that on one. `slower_beside_others` is the same of
a solve on one thread while other processes, which share nothing with it, make the same solve on the
other cores: what the machine takes.

For other codes: `python scripts/bench peers --n 64 128 256 512 1024 2048 4096 --error 1e-3`.
"""

import json
import sys
from concurrent.futures import ThreadPoolExecutor
from itertools import product

from hpc_gfmd.operators.elastic import Elastic
from hpc_gfmd.operators.multilevel import Multilevel
from hpc_gfmd.solvers import solver_class

from .contacts import RoughContact
from .peak import peak_mib
from .report import Report
from .timing import Process, Stopwatch, ratio, run_workers, serve, summary


def run(args):
    """Report every size and precision; the numbers of threads take turns."""
    report = Report("process", args.out)
    for n, precision in product(args.n, args.precision):
        contact = {"n": n, "precision": precision, "p_star": args.p_star}
        jobs = {threads: (1, contact | {"threads": threads}) for threads in args.threads}
        jobs |= {
            (threads, "processes"): (1, contact | {"threads": 1, "companions": threads - 1})
            for threads in args.threads
            if threads > 1
        }
        rounds = run_workers("process", jobs, args.repeats, warm_ups=2)
        for threads in args.threads:
            _add(report, contact, threads, rounds, args.threads[0])
    report.finish()


def _add(report, contact, threads, rounds, fewest):
    """Report a number of threads; ratios are medians over rounds, in which all take turns.

    rounds: rows of all jobs; fewest: the number of threads that others are compared with.
    """
    rows = rounds[threads]
    alone = rounds[fewest]
    beside_others = rounds.get((threads, "processes"), alone)
    one_thread = [fewest * row["seconds"] for row in alone]
    cpu_alone = [row["cpu_seconds"] for row in alone]
    report.add(
        **contact,
        threads=threads,
        efficiency=ratio(one_thread, [threads * row["seconds"] for row in rows]),
        slower_on_threads=ratio([row["cpu_seconds"] for row in rows], cpu_alone),
        slower_beside_others=ratio([row["cpu_seconds"] for row in beside_others], cpu_alone),
        **summary(rows),
    )


def worker(comm, n, p_star, boundary="periodic", companions=0, **settings):
    """Return a function that solves the same contact once more and returns its times, while
    `companions` other processes make the same solve. **settings are arguments of hpc_gfmd.solve."""
    contact = RoughContact(n, p_star, boundary=boundary)
    contact.surface  # noqa: B018 (made before anything is timed)
    cold_seconds = contact.press(**settings)[0]["seconds"]
    watch = Stopwatch()
    solver = solver_class("auto")
    passes = ((solver, "_search"), (solver, "_update"), (Elastic, "columns"), (Multilevel, "sweep"))
    for owner, method in passes:
        watch.watch(owner, method, "passes")
    arguments = {"n": n, "p_star": p_star, "boundary": boundary} | settings
    command = [sys.executable, "-m", "bench.process", json.dumps(arguments)]
    processes = [Process("companion", command) for _ in range(companions)]
    for companion in processes:
        companion.ask()  # is ready when it has answered

    def measure_beside_others():
        with ThreadPoolExecutor(max(companions, 1)) as pool:
            answers = [pool.submit(companion.ask) for companion in processes]
            row = measure()
        for answer in answers:
            answer.result()  # raises its error
        return row

    def measure():
        watch.take()
        row, _ = contact.press(**settings)
        del row["p_star"]  # it is among the arguments
        return row | {
            "cold_seconds": cold_seconds,
            "outside_passes": 1 - watch.take()["passes"] / row["seconds"],
            "peak_mib": peak_mib(),
        }

    return measure_beside_others


if __name__ == "__main__":
    serve(worker)
