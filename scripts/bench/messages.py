"""Messages between the ranks of this machine, copies of all in its memory: for the model of "this
machine". Started by scaling.py."""

import time
from collections.abc import Callable

import numpy as np

from hpc_gfmd.parallel.comm import Comm
from hpc_gfmd.parallel.halo import Windows
from hpc_gfmd.parallel.world import world

from .workers import serve

SMALL, LARGE = 8, 4 * 2**20  # bytes
PIECE = 2**18  # bytes: of a block of columns, as large as those of an all-to-all are
ROWS, SUMS = (
    64,
    8,
)  # of a coarse level and in a reduction of the solver: as many as make no difference
COPIED = 2**26  # bytes: far more than caches hold


def main() -> None:
    """Measure as often as scaling.py asks."""
    comm = world()
    few, many = np.zeros(SMALL, np.uint8), np.zeros(LARGE, np.uint8)
    sent, received = np.zeros((2, comm.size, PIECE), np.uint8)
    source, target = np.ones(COPIED // 4, np.float32), np.ones(COPIED // 4, np.float32)
    starts, sums = ROWS * np.arange(comm.size + 1), [0.0] * SUMS
    halo = Windows(comm.rank, starts, starts[:-1] - 1, starts[1:] + 1)
    rows, window = np.zeros((1, ROWS, ROWS), np.float32), np.zeros((1, ROWS + 2, ROWS), np.float32)

    def measure() -> dict[str, float]:
        found = {
            "ranks": comm.size,
            "copy_bandwidth": 2
            * COPIED
            * comm.size
            / _seconds(comm, lambda: np.copyto(target, source), 4),
        }
        if comm.size > 1:
            others = comm.size - 1
            found |= {
                "latency": _seconds(comm, lambda: _there_and_back(comm, few), 2000) / 2,
                "bandwidth": LARGE / (_seconds(comm, lambda: _there_and_back(comm, many), 20) / 2),
                "alltoall_bandwidth": others
                * PIECE
                / _seconds(comm, lambda: comm.mpi.Alltoall(sent, received), 200 // others),
                "barrier": _seconds(comm, comm.node.barrier, 2000),
                "halo": _seconds(comm, lambda: halo.fill(comm, rows, window), 1000) / 2,
                "sum": _seconds(comm, lambda: comm.sum(sums), 1000),
            }
        return found

    measure()
    serve(comm, measure)


def _seconds(comm: Comm, run: Callable[[], object], times: int) -> float:
    """Seconds of run(), on the slowest rank; one that has nothing to do sleeps."""
    comm.barrier()
    begun = time.perf_counter()
    for _ in range(times):
        run()
    spent = (time.perf_counter() - begun) / times
    if comm.mpi is not None:
        met = comm.mpi.Ibarrier()
        while not met.Test():
            time.sleep(1e-3)
    return float(comm.max([spent])[0])


def _there_and_back(comm: Comm, a: np.ndarray) -> None:
    if comm.rank == 0:
        comm.mpi.Send(a, 1)
        comm.mpi.Recv(a, 1)
    elif comm.rank == 1:
        comm.mpi.Recv(a, 0)
        comm.mpi.Send(a, 0)


if __name__ == "__main__":
    main()
