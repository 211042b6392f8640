"""Scaling of a whole solve under mpirun and on threads, and the share of its parts."""

import time
from functools import partial
from itertools import product

import numpy as np

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
# methods of a communicator in which a rank waits for others
WAITS = ("_allreduce", "bcast", "exchange", "allgather_arrays", "alltoall_bytes", "barrier")


def run(args):
    """Report every precision and size on all ranks and on threads of one rank, which take turns.

    The efficiency is the time for a point, an FFT pair and a core in the first of them over that in
    each of them.
    """
    report = Report("scaling", args.out)
    cores = [(ranks, 1) for ranks in args.ranks] + [(1, t) for t in args.threads if t > 1]
    for precision, n in product(args.precision, args.n):
        contact = {"n": n, "precision": precision, "p_star": args.p_star}
        jobs = {key: (key[0], contact | {"threads": key[1]}) for key in cores}
        first_cost = None
        for (ranks, threads), rows in run_workers("scaling", jobs, args.repeats, WARM_UPS).items():
            row = summary(rows)
            cost = row["seconds_min"] * ranks * threads / (n**2 * row["fft_pairs"])
            first_cost = first_cost or cost
            report.add(efficiency=first_cost / cost, **row)
    report.finish()


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
    for method in WAITS:
        watch.watch(MpiComm, method, "messages")

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
        seconds_of_parts = comm.sum([parts["levels"], parts["messages"]])
        share_levels, share_messages = (seconds_of_parts / comm.size / elapsed).tolist()
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
            "share_messages": share_messages,
            "iterations": load.iterations,
            "fft_pairs": load.fft_pairs,
        }

    return measure


if __name__ == "__main__":
    serve(worker)
