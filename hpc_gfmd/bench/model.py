"""A performance model: one core's measured speed, memory bandwidth shared on a node, and a network of latency and bandwidth.

One FFT pair, with everything that goes along with it, takes per rank (n x n points, P ranks, c ranks on each of the nodes)

    compute      N/P (t_fft log2 N + t_kernel) s(c)     s(c): slow-down by the shared memory bandwidth of a node
    transpose    2 (alltoall of N/P complex halves): bytes over the node's link, K blocks of P messages each
    levels       log2(n/P) halo exchanges down and up, then one allreduce of the level that is summed onto all ranks
    reductions   3 small allreduces, 2 latency log2 P each

The slab limit is P <= n. Nothing overlaps in the model, as nothing does in the code.
"""

from dataclasses import dataclass

import numpy as np

from ..parallel.fft import COLUMN_BYTES, MIN_WIDTH


@dataclass(frozen=True)
class Machine:
    """fft: seconds per point and log2 N, kernel: seconds per point, of one FFT pair on one core; pairs: FFT pairs of a solve;
    itemsize: bytes of a real number; cores: per node; saturated: cores that use up a node's memory bandwidth."""

    fft: float
    kernel: float
    pairs: float
    itemsize: int = 4
    cores: int = 64
    saturated: int = 24

    @classmethod
    def from_row(cls, row):
        """From a measured row on one rank."""
        N, pairs = row["n"] ** 2, row["fft_pairs"]
        per_pair = row["seconds"] / pairs / N
        share = row["share_fft"]
        return cls(per_pair * share / np.log2(N), per_pair * (1 - share), pairs, 4 if row["precision"] == "single" else 8)

    def slowdown(self, ranks):
        """How much slower a core is when `ranks` of them work on a node."""
        return max(1.0, min(ranks, self.cores) / self.saturated)

    def describe(self):
        """The assumptions in one line."""
        return (f"nodes of {self.cores} cores whose memory feeds {self.saturated}; one core: FFT {1e9 * self.fft:.3g} ns per point and "
                f"log2 N, the rest {1e9 * self.kernel:.3g} ns per point, of each of {self.pairs:.1f} pairs")


@dataclass(frozen=True)
class Network:
    """latency in seconds per message, bandwidth of a node's link in bytes per second each way."""

    latency: float = 2e-6
    bandwidth: float = 12.5e9

    def describe(self):
        """The assumptions in one line."""
        return f"network of {1e6 * self.latency:g} us and {self.bandwidth / 1e9:g} GB/s per node"


def predict(n, nodes, machine, network, ranks_per_node=None):
    """One row of the model: seconds of a solve, parallel efficiency against one core, shares; None beyond the slab limit."""
    per_node = ranks_per_node or min(machine.cores, max(1, n // nodes))
    P, N = nodes * per_node, n * n
    if P > n:
        return None
    compute = N / P * (machine.fft * np.log2(N) + machine.kernel) * machine.slowdown(per_node)
    off_node = N / nodes * machine.itemsize * (1 - 1 / nodes)  # a complex half spectrum has the bytes of the real field
    width = max(MIN_WIDTH, COLUMN_BYTES // (n * 2 * machine.itemsize))
    blocks = -(-(n // 2 + 1) // (P * width))
    transpose = 2 * off_node / network.bandwidth
    levels = max(0.0, np.log2(n / P))
    whole = max(P, 128) ** 2 * 2 * machine.itemsize  # the level that is summed onto every rank, two fields
    hop = network.latency * (np.log2(P) if P > 1 else 0.0)
    messages = 2 * blocks * (P - per_node) * network.latency + 4 * levels * network.latency * (nodes > 1) + 8 * hop
    summed = 2 * whole / network.bandwidth * (nodes > 1)
    pair = compute + transpose + messages + summed
    alone = N * (machine.fft * np.log2(N) + machine.kernel)
    return {"n": n, "nodes": nodes, "ranks": P, "seconds": float(machine.pairs * pair), "efficiency": float(alone / (pair * P)),
            "share_transpose": float(transpose / pair), "share_latency": float((messages + summed) / pair),
            "gib_per_node": float(6 * N * machine.itemsize / nodes / 2**30)}
