"""Strong and weak scaling of a whole solve under mpirun, where its time goes, and what model.py
makes of it on a cluster."""

import time
from dataclasses import replace
from functools import partial
from itertools import product

import numpy as np
from scipy.fft import next_fast_len

from hpc_gfmd.driver.load import Load
from hpc_gfmd.driver.sweep import make_sweep
from hpc_gfmd.driver.warmup import compile_once
from hpc_gfmd.operators.multilevel import Multilevel
from hpc_gfmd.parallel.comm import MpiComm

from .contacts import Case
from .model import CLUSTERS, Machine, predict
from .pictures import Panel, picture
from .report import Report
from .timing import Stopwatch, measured, seconds, serve, summary

ACCURACY = 1e-2
SMALL = 32  # points along an axis: what a solve takes there is the interpreter's
COPIED = 2**26  # bytes: far more than caches hold
# what a rank waits in, by the method of its communicator
WAITS = {
    "_allreduce": "sums",
    "bcast": "broadcasts",
    "exchange": "rows",
    "allgather_arrays": "rows",
    "alltoall_bytes": "transposes",
    "barrier": "meetings",
}
WARM_UP = 4  # solves of a process: until then the system still finds it large pages


def run(args):
    """Measure every n on all ranks (strong), on threads of one rank, and the smallest n grown with
    sqrt(ranks) (weak), all of a size in turn; then predict larger machines. args: of command.py."""
    report = Report("scaling", args.out)
    ranks = [(k, 1) for k in args.ranks]
    threads = [(1, t) for t in args.threads if t > 1]
    for precision in args.precision:
        for n in args.n:
            _add(report, "strong", dict.fromkeys(ranks + threads, n), precision, args)
        _add(report, "weak", {(k, 1): _grown(min(args.n), k) for k, _ in ranks}, precision, args)
    if 1 in args.ranks:
        _predict(report, args)
    report.finish()


def _add(report, kind, sizes, precision, args):
    """Report the solves of some sizes by (ranks, threads); efficiency: time of a point, a pair and
    a core of the first over that."""
    jobs = {
        (ranks, threads): (
            ranks,
            {"n": n, "precision": precision, "p_star": args.p_star, "threads": threads},
        )
        for (ranks, threads), n in sizes.items()
    }
    first = None
    for (ranks, threads), rows in measured("scaling", jobs, args.repeats, WARM_UP).items():
        row = summary(rows)
        cost = row["seconds_min"] * ranks * threads / (row["n"] ** 2 * row["fft_pairs"])
        first = first or cost
        report.add(kind=kind, efficiency=first / cost, **row)


def _grown(n, ranks):
    """Find the multiple of 4 nearest above n sqrt(ranks) that has small prime factors: others are
    slow to transform."""
    return 4 * next_fast_len(round(n * ranks**0.5 / 4), real=True)


def _predict(report, args):
    """Report what the model makes of one core of this machine on clusters."""
    of = {"precision": args.precision[0], "p_star": args.p_star, "threads": 1, "n": SMALL}
    small = summary(measured("scaling", {1: (1, of)}, args.repeats, WARM_UP)[1])
    alone = {"kind": "strong", "ranks": 1, "threads": 1, "precision": args.precision[0]}
    rows = [row for row in report.rows if alone.items() <= row.items()]
    serial = max(rows, key=lambda row: row["n"])
    machine = Machine.of(serial, small)
    model = Report("scaling-model", args.out)
    model.note(str(machine))
    for link, n, nodes in product(CLUSTERS, (2**15, 2**17), range(11)):
        if said := predict(n, 2**nodes, replace(machine, link=link)):
            model.add(**said)
    model.finish()
    if report.path:
        keys = "kind", "n", "threads", "precision"
        panels = [
            Panel(report.rows, keys, "ranks", what, scale="linear")
            for what in ("efficiency", "share_messages")
        ]
        panels.append(Panel(model.rows, ("n", "link_gb_per_s"), "nodes", "seconds", "by the model"))
        picture(report.path.with_suffix(".png"), panels)


def worker(comm, n, precision, p_star, threads):
    """Return what solves once."""
    case = Case(n, p_star)
    scene = case.scene(solver={"precision": precision, "accuracy": ACCURACY})
    compile_once(comm, scene, lambda contact: None)
    sweep = make_sweep(partial(case.build, comm, threads=threads), scene.solver)
    source, target = np.ones((2, COPIED // 4), np.float32)
    watch = Stopwatch()
    watch.watch(Multilevel, "sweep", "levels")
    for method, name in WAITS.items():
        watch.watch(MpiComm, method, name)
    names = list(dict.fromkeys(WAITS.values()))

    def measure():
        sweep.starter.forget()
        comm.barrier()
        watch.take()
        begun, cpu = time.perf_counter(), time.process_time()
        step = sweep.solve(Load("pressure", p_star * sweep.surface.g_rms))
        comm.barrier()
        spent = time.perf_counter() - begun
        parts = watch.take()
        seconds_of = [parts["levels"], *(parts[name] for name in names)]
        levels, *waits = (comm.sum(seconds_of) / comm.size / spent).tolist()
        return {
            "n": n,
            "ranks": comm.size,
            "threads": threads,
            "precision": precision,
            "p_star": p_star,
            "accuracy": ACCURACY,
            "seconds": spent,
            "cpu_seconds": time.process_time() - cpu,
            "copy_bandwidth": 2 * COPIED / seconds(lambda: np.copyto(target, source), comm),
            "share_levels": levels,
            "share_messages": sum(waits),
            **{f"share_{name}": share for name, share in zip(names, waits)},
            "iterations": step.iterations,
            "fft_pairs": step.fft_pairs,
        }

    return measure


if __name__ == "__main__":
    serve(worker)
