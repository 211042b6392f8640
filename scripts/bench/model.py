"""A performance model: measured speed of one core, the memory bandwidth of a node, and a network,
put together with what every rank has and sends by the code's own account (runs/decomposition.py).

An FFT pair on one grid, with everything that goes along with it, takes on the rank that has most

    compute      what the interpreter takes, and points times one core's time, of which the memory's
    part grows as its bandwidth is
                 shared; levels of the preconditioner are swept by one thread, and what is gathered
                 on this rank comes on top
    transpose    bytes to other nodes over its share of the node's link, overhead and latency of
    their messages; what is within the
                 node is read where it stands, and is one of the passes of "compute"; two meetings
                 of the ranks of a node
    levels       halo and gathered rows: bytes over the link, the program's work and a latency for
    each message reductions   a latency for each stage

and a solve such pairs on the finest grid and a few on every grid of the nested start. Nothing
overlaps, as nothing does in the code. Not in the model: surface generation, reading and writing,
contention in the network, and ranks that wait for each other. It is too fast: on 16 cores a solve
took 1.1 to 1.6 times what it says (docs/clusters.md).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from hpc_gfmd.parallel.comm import stages
from hpc_gfmd.runs.decomposition import Share, share_of

from .passes import field_passes

MOST_THREADS = 8  # of a rank: more were never measured
START_AND_END = (
    2  # FFT pairs on the finest grid beside its iterations: the first pressure and the certificate
)


@dataclass(frozen=True)
class Machine:
    """fft: seconds per point and log2 N, kernel: seconds per point, of one FFT pair on one core;
    levels: share of the time that goes into the levels; pairs, coarse_pairs: FFT pairs on the
    finest grid and on each coarser one; itemsize: bytes of a real number; call: seconds of a pair,
    on a grid of whatever size, in the interpreter; bandwidth_alone: of one core with the memory to
    itself; cores: of a node, bandwidth: of its memory in bytes per second (one socket with eight
    channels of DDR4-3200, as STREAM finds); barrier: seconds of a stage of a meeting of ranks of a
    node; halo: that the program takes to send and place the rows of a message (the last two as 16
    ranks found)."""

    fft: float
    kernel: float
    levels: float
    pairs: float
    coarse_pairs: float
    itemsize: int = 4
    call: float = 0.0
    bandwidth_alone: float = 17e9
    cores: int = 64
    bandwidth: float = 170e9
    barrier: float = 1e-6
    halo: float = 40e-6

    @classmethod
    def from_row(
        cls, row: dict, small: dict | None = None, bandwidth_alone: float = bandwidth_alone
    ) -> Machine:
        """From a measured row on one rank; small: that of a grid whose points take no time."""
        points, pairs = cls._work(row)
        call = small["seconds"] / cls._work(small)[1].sum() if small else 0.0
        work, busy = points * pairs, row["seconds"] - call * pairs.sum()
        fft = row["seconds"] * row["share_fft"]
        return cls(
            fft / (work * np.log2(points)).sum(),
            (busy - fft) / work.sum(),
            row["share_levels"],
            pairs[0],
            pairs[1] if len(pairs) > 1 else 0.0,
            4 if row["precision"] == "single" else 8,
            call,
            bandwidth_alone,
        )

    @staticmethod
    def _work(row: dict) -> tuple[np.ndarray, np.ndarray]:
        """Points of every grid, and the FFT pairs on it."""
        points = np.array([part.points for part in _grids((row["n"], row["n"]), 1)], float)
        pairs = min(row["iterations"] + START_AND_END, row["fft_pairs"])
        coarse = (
            (row["fft_pairs"] - pairs) * points[0] / points[1:].sum() if len(points) > 1 else 0.0
        )
        return points, np.array([pairs, *[coarse] * (len(points) - 1)])

    @property
    def bytes_per_point(self) -> float:
        """Bytes that an FFT pair moves between memory and caches for each point, as
        bench/kernels.py counts them."""
        return self.itemsize * sum(field_passes([(2**k, 2**k) for k in range(14, -1, -1)]).values())

    def seconds_per_point(self, N: float) -> float:
        """Of one FFT pair on one core that has the memory to itself, without the interpreter's."""
        return self.fft * np.log2(N) + self.kernel

    def describe(self) -> str:
        """The assumptions in one line."""
        return (
            f"nodes of {self.cores} cores with {self.bandwidth / 1e9:g} GB/s of memory; one core:"
            f" FFT {1e9 * self.fft:.3g} ns per point and log2 N, the rest {1e9 * self.kernel:.3g}"
            f" ns per point, {self.levels:.0%} in the levels, {self.bytes_per_point:.3g} bytes per"
            f" point at {self.bandwidth_alone / 1e9:.3g} GB/s, {1e3 * self.call:.2g} ms of the"
            f" interpreter; {self.pairs:.1f} pairs, {self.coarse_pairs:.1f} on each coarser grid"
        )


@dataclass(frozen=True)
class Network:
    """latency: seconds until a message is there; overhead: that a rank is busy with each;
    bandwidth: of a node's link each way.

    The defaults: 100 Gbit/s of Omni-Path or InfiniBand EDR, as makers tell. What an all-to-all of
    many nodes gets of it is less: docs/clusters.md.
    """

    latency: float = 2e-6
    overhead: float = 0.4e-6
    bandwidth: float = 12.5e9

    def describe(self) -> str:
        """The assumptions in one line."""
        return (
            f"network of {1e6 * self.latency:g} us, {1e6 * self.overhead:g} us of work per message"
            f" and {self.bandwidth / 1e9:g} GB/s per node"
        )


@dataclass(frozen=True)
class _Part:
    """The numbers of a Share, of rank 0, that the model takes. here: ranks of its node with a part
    in the grid; K: all-to-alls of a transform; transpose: (bytes, messages) to other nodes."""

    here: int
    N: int
    points: int
    gathered: float
    K: int
    transpose: tuple[int, int]
    levels: tuple[int, int]
    stages: int


@cache
def _grids(n: tuple[int, int], ranks: int, itemsize: int = 4, per_node: int = 1) -> list[_Part]:
    """A grid and all coarser ones of the nested start."""
    finest = share_of(n, np.float32 if itemsize == 4 else np.float64, ranks, per_node=per_node)
    shares = [finest, *(Share(grid, finest.dtype) for grid in finest.grids)]
    return [
        _Part(
            len(share.grid.comm.node_ranks),
            share.grid.cell_points,
            share.points,
            max(share.level_points - share.points / 3, 0.0),
            share.layout.K,
            share.transpose_traffic,
            share.level_traffic,
            share.reduction_traffic[1],
        )
        for share in shares
    ]


def _pair(part: _Part, machine: Machine, network: Network, threads: int) -> np.ndarray:
    """Seconds of the parts of an FFT pair on a grid: compute, transpose, levels and reductions."""
    alone, memory = (
        machine.seconds_per_point(part.N),
        machine.bytes_per_point / machine.bandwidth_alone,
    )
    in_core = max(alone - memory, 0.0) * (machine.levels + (1 - machine.levels) / threads)
    crowded = machine.bytes_per_point * part.here / machine.bandwidth
    compute = part.points * (in_core + max(memory / threads, crowded))
    compute += machine.call + part.gathered * 3 * machine.levels * alone

    (nbytes, messages), (level_bytes, level_messages) = part.transpose, part.levels
    transpose = nbytes * part.here / network.bandwidth + messages * network.overhead
    transpose += 2 * part.K * network.latency * (messages > 0) + 2 * machine.barrier * stages(
        part.here
    )
    levels = level_bytes / network.bandwidth + level_messages * (machine.halo + network.latency)
    return np.array([compute, transpose, levels, part.stages * network.latency])


def _solve(
    n: int, ranks: int, ranks_per_node: int, threads: int, machine: Machine, network: Network
) -> np.ndarray:
    """Seconds of the parts of a solve."""
    finest, *coarser = (
        _pair(part, machine, network, threads)
        for part in _grids((n, n), ranks, machine.itemsize, ranks_per_node)
    )
    return machine.pairs * finest + machine.coarse_pairs * sum(coarser, np.zeros(4))


def predict(
    n: int, nodes: int, machine: Machine, network: Network, ranks_per_node: int | None = None
) -> dict[str, Any] | None:
    """One row of the model: seconds of a solve with the best number of ranks and threads on each
    node (or the one given), efficiency against one core and against one full node, shares, and the
    part of the bandwidth of the nodes' memory that is used; None beyond the slab limit of one row
    for each rank."""
    choices = (
        [2**k for k in range(machine.cores.bit_length())]
        if ranks_per_node is None
        else [ranks_per_node]
    )
    choices = [
        k for k in choices if machine.cores / MOST_THREADS <= k <= machine.cores and nodes * k <= n
    ]
    if not choices:
        return None
    parts, per_node = min(
        ((_solve(n, nodes * k, k, machine.cores // k, machine, network), k) for k in choices),
        key=lambda found: found[0].sum(),
    )
    seconds = float(parts.sum())
    alone = _solve(n, 1, 1, 1, machine, network).sum()
    on_one_node = min(_solve(n, k, k, machine.cores // k, machine, network).sum() for k in choices)
    moved = n * n * machine.bytes_per_point * (machine.pairs + machine.coarse_pairs / 3)
    return {
        "n": n,
        "nodes": nodes,
        "ranks": nodes * per_node,
        "threads": machine.cores // per_node,
        "network_gb_per_s": network.bandwidth / 1e9,
        "seconds": seconds,
        "efficiency": float(alone / (seconds * nodes * machine.cores)),
        "of_one_node": float(on_one_node / (seconds * nodes)),
        "share_transpose": float(parts[1] / seconds),
        "share_latency": float(parts[2:].sum() / seconds),
        "of_bandwidth": float(moved / nodes / machine.bandwidth / seconds),
        "gib_per_node": float(6 * n * n * machine.itemsize / nodes / 2**30),
    }
