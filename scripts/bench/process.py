"""A solve in one process, as in a notebook: the first one, those that follow on the same surface,
on threads, the share of the time that is outside of the solver's passes, and the time in which
fewer threads work than there are, by part (idle.py), as shares of the time of one thread.

Other codes beside it: `python scripts/bench peers --n 64 128 256 512 1024 2048 4096 --error 1e-3`.
"""

from itertools import product

from .contacts import Case
from .idle import IdleWatch
from .kernels import watch_passes
from .peak import peak_mib
from .report import Report
from .timing import measured, serve, summary

PARTS = "python", "hand_overs", "coarse_levels", "set_up"


def run(args):
    """Report every size; all numbers of threads in turn. args: of command.py."""
    report = Report("process", args.out)
    for n, precision in product(args.n, args.precision):
        of = {"n": n, "precision": precision, "p_star": args.p_star}
        jobs = {threads: (1, of | {"threads": threads}) for threads in args.threads}
        alone = None
        for threads, rows in measured("process", jobs, args.repeats, 2).items():
            found = summary(rows)
            cores_seconds = found["seconds_min"] * threads
            alone = alone or cores_seconds
            quickest = min(rows, key=lambda row: row["seconds"])
            short = {f"short_{part}": quickest[part] / alone for part in PARTS}
            short["short_in_all"] = sum(short.values())
            found = {key: value for key, value in found.items() if key not in PARTS}
            report.add(**of, threads=threads, efficiency=alone / cores_seconds, **short, **found)
    report.finish()


def worker(comm, n, p_star, boundary="periodic", **settings):
    """Return what presses the same surface once more; settings: of hpc_gfmd.solve."""
    case = Case(n, p_star, boundary=boundary)
    case.surface  # noqa: B018 (made here, outside of the times)
    cold = case.press(**settings)[0]["seconds"]
    watch = watch_passes()
    idle = IdleWatch()

    def measure():
        watch.take()
        idle.take()
        row, _ = case.press(**settings)
        short = idle.take()
        del row["p_star"]  # as given
        return (
            row
            | {part: short[part] for part in PARTS}
            | {
                "cold_seconds": cold,
                "outside_passes": 1 - sum(watch.take().values()) / row["seconds"],
                "peak_mib": peak_mib(),
            }
        )

    return measure


if __name__ == "__main__":
    serve(worker)
