"""Strong and weak scaling of a whole solve under mpirun, and the share of its parts."""

import time
from functools import partial

import numpy as np
from scipy.fft import next_fast_len

from hpc_gfmd.driver.contact_model import ContactModel
from hpc_gfmd.driver.load import Load
from hpc_gfmd.driver.sweep import Sweep
from hpc_gfmd.driver.warmup import compile_once
from hpc_gfmd.operators.multilevel import Multilevel
from hpc_gfmd.parallel.comm import MpiComm

from .contacts import RoughContact
from .report import Report
from .timing import Stopwatch, run_workers, seconds, serve, summary

ACCURACY = 1e-2
COPIED_BYTES = 2**26  # far more than caches hold
WARM_UPS = 4  # solves of a process before the system has given it large pages
# what a rank waits in, by the method of its communicator
WAITS = {
    "_allreduce": "sums",
    "bcast": "broadcasts",
    "exchange": "rows",
    "allgather_arrays": "rows",
    "alltoall_bytes": "transposes",
    "barrier": "meetings",
}


def run(args):
    """Measure strong scaling for every n, and weak scaling from the smallest n.

    Strong scaling is measured on all ranks and on threads of one rank. For weak scaling n grows
    with sqrt(ranks). The runs of one size take turns.
    """
    report = Report("scaling", args.out)
    ranks = [(k, 1) for k in args.ranks]
    threads = [(1, t) for t in args.threads if t > 1]
    for precision in args.precision:
        for n in args.n:
            _add(report, "strong", dict.fromkeys(ranks + threads, n), precision, args)
        _add(report, "weak", {(k, 1): _grown(min(args.n), k) for k, _ in ranks}, precision, args)
    report.finish()


def _add(report, kind, sizes, precision, args):
    """Report the solves of {(ranks, threads): n}.

    The efficiency is the time for a point, an FFT pair and a core in the first of them over that in
    each of them.
    """
    jobs = {
        (ranks, threads): (
            ranks,
            {"n": n, "precision": precision, "p_star": args.p_star, "threads": threads},
        )
        for (ranks, threads), n in sizes.items()
    }
    first_cost = None
    for (ranks, threads), rows in run_workers("scaling", jobs, args.repeats, WARM_UPS).items():
        row = summary(rows)
        cost = row["seconds_min"] * ranks * threads / (row["n"] ** 2 * row["fft_pairs"])
        first_cost = first_cost or cost
        report.add(kind=kind, efficiency=first_cost / cost, **row)


def _grown(n, ranks):
    """Return the next multiple of 4 from n sqrt(ranks) that has small prime factors: transforms of
    other lengths are slow."""
    return 4 * next_fast_len(round(n * ranks**0.5 / 4), real=True)


def worker(comm, n, precision, p_star, threads):
    """Return a function that solves one contact and returns its times. Collective."""
    contact = RoughContact(n, p_star)
    scene = contact.scene(solver={"precision": precision, "accuracy": ACCURACY})
    compile_once(comm, scene, lambda contact: None)
    build = partial(contact.build, comm, threads=threads)
    sweep = Sweep(build, scene.solver, ContactModel())
    source, target = np.ones((2, COPIED_BYTES // 4), np.float32)
    watch = Stopwatch()
    watch.watch(Multilevel, "sweep", "levels")
    for method, name in WAITS.items():
        watch.watch(MpiComm, method, name)
    names = list(dict.fromkeys(WAITS.values()))

    def measure():
        sweep.starter.forget()
        comm.barrier()
        watch.take()
        wall_begin = time.perf_counter()
        cpu_begin = time.process_time()
        load = sweep.solve(Load("pressure", p_star * sweep.surface.g_rms))
        comm.barrier()
        elapsed = time.perf_counter() - wall_begin
        parts = watch.take()
        seconds_of = [parts["levels"], *(parts[name] for name in names)]
        share_levels, *waits = (comm.sum(seconds_of) / comm.size / elapsed).tolist()
        return {
            "n": n,
            "ranks": comm.size,
            "threads": threads,
            "precision": precision,
            "p_star": p_star,
            "accuracy": ACCURACY,
            "seconds": elapsed,
            "cpu_seconds": time.process_time() - cpu_begin,
            "copy_bandwidth": 2 * COPIED_BYTES / seconds(lambda: np.copyto(target, source), comm),
            "share_levels": share_levels,
            "share_messages": sum(waits),
            **{f"share_{name}": share for name, share in zip(names, waits)},
            "iterations": load.iterations,
            "fft_pairs": load.fft_pairs,
        }

    return measure


if __name__ == "__main__":
    serve(worker)
