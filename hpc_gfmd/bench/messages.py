"""Messages between two ranks of this machine and copies in its memory: what the model says of "this machine". Started by scaling.py."""

import time
from collections.abc import Callable
from functools import partial

import numpy as np

from ..parallel.comm import Comm
from ..parallel.world import world
from .workers import serve

SMALL, LARGE = 8, 4 * 2**20  # bytes
PIECE = 2**18  # bytes: of a block of columns, as large as those of an all-to-all are
COPIED = 2**26  # bytes: far more than caches hold


def main() -> None:
    """Measure as often as scaling.py asks."""
    comm = world()
    few, many = np.zeros(SMALL, np.uint8), np.zeros(LARGE, np.uint8)
    sent, received = np.zeros((2, PIECE), np.uint8), np.zeros((2, PIECE), np.uint8)
    source, target = np.ones(COPIED // 4, np.float32), np.ones(COPIED // 4, np.float32)

    def copy(ranks: int) -> None:
        if comm.rank < ranks:
            np.copyto(target, source)

    def measure() -> dict[str, float]:
        found = {"latency": _seconds(comm, lambda: _there_and_back(comm, few), 2000) / 2,
                 "bandwidth": LARGE / (_seconds(comm, lambda: _there_and_back(comm, many), 20) / 2),
                 "alltoall_bandwidth": PIECE / _seconds(comm, lambda: comm.mpi.Alltoall(sent, received), 200),
                 "barrier": _seconds(comm, comm.node.barrier, 2000)}
        for name, ranks in (("copy_bandwidth", 1), ("copy_bandwidth_of_two", 2)):
            found[name] = 2 * COPIED * ranks / _seconds(comm, partial(copy, ranks), 4)
        return found

    measure()
    serve(comm, measure)


def _seconds(comm: Comm, run: Callable[[], object], times: int) -> float:
    """Seconds of run(), on the slower rank; one that has nothing to do sleeps."""
    comm.barrier()
    begun = time.perf_counter()
    for _ in range(times):
        run()
    spent = (time.perf_counter() - begun) / times
    met = comm.mpi.Ibarrier()
    while not met.Test():
        time.sleep(1e-3)
    return float(comm.max([spent])[0])


def _there_and_back(comm: Comm, a: np.ndarray) -> None:
    if comm.rank == 0:
        comm.mpi.Send(a, 1)
        comm.mpi.Recv(a, 1)
    else:
        comm.mpi.Recv(a, 0)
        comm.mpi.Send(a, 0)


if __name__ == "__main__":
    main()
