"""A performance model: measured speed of one core, the memory bandwidth of a node, and a network,
put together with what every rank has and sends by the code's own account (runs/decomposition.py).

An FFT pair on one grid, with everything that goes along with it, takes on the rank that has most

    compute      what the interpreter takes, and N log2 N times one core's time, of which the
                 memory's part grows as its bandwidth is shared; levels gathered on it come on top
    transpose    bytes to other nodes over its share of the node's link, overhead and latency of
                 their messages; what is within the node is read where it stands; two meetings of
                 the ranks of a node
    levels       halo and gathered rows: bytes over the link, the program's work and a latency for
                 each message
    reductions   a latency for each stage

and a solve such pairs on the finest grid and a few on every grid of the nested start. Nothing
overlaps, as nothing does in the code. Not in the model: surface generation, reading and writing,
contention in the network, and ranks that wait for each other. It is too fast: on 16 cores a solve
took 1.1 to 1.6 times what it says (docs/clusters.md).
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from hpc_gfmd.parallel.comm import stages
from hpc_gfmd.runs.decomposition import Share, share_of

from .kernels import field_passes

START_AND_END = 2  # pairs on the finest grid beside its iterations: first pressure, certificate
# bytes per second: a link of 100 Gbit/s, what P3DFFT reached of such a one on 26 nodes
# (docs/clusters.md), and one of 200 Gbit/s
CLUSTERS = (12.5e9, 7e9, 25e9)


@dataclass(frozen=True)
class Machine:
    """What the model takes for granted.

    work: seconds per point and log2 N of an FFT pair on one core; levels: share of it in the
    levels; pairs, coarse_pairs: on the finest grid and on each coarser one; itemsize: bytes of a
    real number; call: seconds of a pair in the interpreter; bandwidth_alone: of one core with the
    memory to itself; cores: of a node, a rank each; bandwidth: of its memory in bytes per second
    (one socket with eight channels of DDR4-3200, as STREAM finds); barrier: seconds of a stage of a
    meeting of ranks of a node; halo: that the program takes to send and place the rows of a message
    (both as 16 ranks found); latency: seconds until a message is there; overhead: that a rank is
    busy with each; link: bytes per second of a node each way.
    """

    work: float
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
    latency: float = 2e-6
    overhead: float = 0.4e-6
    link: float = 12.5e9

    @classmethod
    def of(cls, row, small):
        """Make it of a row of scaling.py on one rank; small: a row of a grid whose points take no
        time."""
        call = small["seconds_min"] / _pairs(small)[1].sum()
        points, pairs = _pairs(row)
        work = (row["seconds_min"] - call * pairs.sum()) / (points * np.log2(points) * pairs).sum()
        itemsize = 4 if row["precision"] == "single" else 8
        coarse = pairs[1] if len(pairs) > 1 else 0.0
        share = row["share_levels"]
        return cls(work, share, pairs[0], coarse, itemsize, call, row["copy_bandwidth"])

    @property
    def bytes_per_point(self):
        """Count the bytes that an FFT pair moves between memory and caches for each point."""
        return self.itemsize * sum(field_passes([(2**k, 2**k) for k in range(14, -1, -1)]).values())


def _pairs(row):
    """Count the points of every grid, and the FFT pairs on it."""
    points = np.array([share.points for share in _shares(row["n"], 1)], float)
    pairs = min(row["iterations"] + START_AND_END, row["fft_pairs"])
    coarse = (row["fft_pairs"] - pairs) * points[0] / max(points[1:].sum(), 1)
    return points, np.array([pairs, *[coarse] * (len(points) - 1)])


@cache
def _shares(n, ranks, itemsize=4, per_node=1):
    """Find what rank 0 has of a grid and of all coarser ones of the nested start."""
    finest = share_of((n, n), np.float32 if itemsize == 4 else np.float64, ranks, per_node=per_node)
    return [finest, *(Share(grid, finest.dtype) for grid in finest.grids)]


def _pair(share, machine):
    """Predict the seconds of the parts of an FFT pair on a grid: compute; transpose; levels and
    reductions."""
    here = len(share.grid.comm.node_ranks)  # ranks of its node with a part in the grid
    alone = machine.work * np.log2(share.grid.cell_points)
    memory = machine.bytes_per_point / machine.bandwidth_alone
    crowded = machine.bytes_per_point * here / machine.bandwidth
    gathered = max(share.level_points - share.points / 3, 0.0)
    compute = share.points * (max(alone - memory, 0.0) + max(memory, crowded))
    compute += machine.call + gathered * 3 * machine.levels * alone
    (nbytes, messages), (level_bytes, level_messages) = share.layout.traffic(), share.level_traffic
    transpose = nbytes * here / machine.link + messages * machine.overhead
    transpose += 2 * share.layout.K * machine.latency * (messages > 0)
    transpose += 2 * machine.barrier * stages(here)
    others = level_bytes / machine.link + level_messages * machine.halo
    others += (level_messages + share.reduction_traffic[1]) * machine.latency
    return np.array([compute, transpose, others])


def _solve(n, ranks, machine):
    """Predict the seconds of the same parts of a solve."""
    shares = _shares(n, ranks, machine.itemsize, machine.cores)
    finest, *coarser = (_pair(share, machine) for share in shares)
    return machine.pairs * finest + machine.coarse_pairs * sum(coarser, np.zeros(3))


def predict(n, nodes, machine):
    """Return one row of the model: seconds of a solve, efficiency against one full node, the share
    of transposes and of messages of the levels and reductions, and the part of the bandwidth of the
    nodes' memory that is used; None beyond the slab limit of one row for each rank."""
    if nodes * machine.cores > n:
        return None
    parts = _solve(n, nodes * machine.cores, machine)
    one_node = _solve(n, machine.cores, machine)
    moved = n * n * machine.bytes_per_point * (machine.pairs + machine.coarse_pairs / 3)
    return {
        "n": n,
        "nodes": nodes,
        "link_gb_per_s": machine.link / 1e9,
        "seconds": float(parts.sum()),
        "of_one_node": float(one_node.sum() / (parts.sum() * nodes)),
        "share_transpose": float(parts[1] / parts.sum()),
        "share_others": float(parts[2] / parts.sum()),
        "of_bandwidth": float(moved / nodes / machine.bandwidth / parts.sum()),
    }
