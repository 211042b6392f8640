"""A performance model of a cluster.

It combines the measured speed of one core, the memory bandwidth of a node and a network with the
points and messages of every rank, which the code itself counts (decomposition.py). The time of
an FFT pair on one grid, with everything that belongs to an iteration, is the sum of four parts on
the rank that has most to do:

    compute      the interpreter, and N log2 N times the time of one core, whose share that waits
                 for memory grows as the bandwidth of the node is shared; the coarse levels that are
                 gathered on one rank come on top
    transpose    bytes to other nodes over the rank's share of the node's link, with an overhead and
                 a latency for each message; data within the node are read in place; two barriers
                 among the ranks of a node
    levels       halo rows and gathered rows: bytes over the link, and the program's work and a
                 latency for each message
    reductions   a latency for each stage

A solve takes several such pairs on the finest grid and a few on every grid of the nested start.
Nothing overlaps, as in the code. The model ignores the generation of surfaces, input and output,
contention in the network and waiting for slower ranks. It is optimistic: on 16 cores a solve took
1.1 to 1.6 times the predicted time (docs/clusters.md).
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from .decomposition import Share, share_of, stages, transpose_traffic

START_AND_END = 2  # pairs on the finest grid beside the iterations: first pressure, certificate
# Bytes per second of a node's link: 100 Gbit/s, what P3DFFT reached with such a link on 26 nodes
# (docs/clusters.md), and 200 Gbit/s.
CLUSTERS = (12.5e9, 7e9, 25e9)


@dataclass(frozen=True)
class Machine:
    """The costs that the model assumes.

    Attributes
    ----------
    work : float
        Seconds per point and log2 N of an FFT pair on one core.
    levels : float
        Share of `work` in the levels of the preconditioner.
    pairs, coarse_pairs : float
        FFT pairs on the finest grid, and on each coarser one.
    itemsize : int
        Bytes of a real number.
    call : float
        Seconds of a pair in the interpreter.
    bandwidth_alone : float
        Bytes per second of one core that has the memory to itself.
    cores : int
        Cores of a node, with one rank each.
    bandwidth : float
        Memory bandwidth of a node (bytes per second): one socket with eight channels of DDR4-3200,
        as STREAM measures it.
    barrier : float
        Seconds of one stage of a barrier within a node, measured on 16 ranks.
    halo : float
        Seconds that the program takes to send and store the rows of a message, measured on 16
        ranks.
    latency : float
        Seconds until a message arrives.
    overhead : float
        Seconds that each message keeps a rank busy.
    link : float
        Bytes per second that a node sends and receives at the same time.
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
        """Return the machine that matches measured times.

        Parameters
        ----------
        row : dict
            A row of scaling.py on one rank.
        small : dict
            The same on a grid so small that its points take no time.
        """
        call = small["seconds_min"] / _points_and_pairs(small)[1].sum()
        points, pairs = _points_and_pairs(row)
        work = (row["seconds_min"] - call * pairs.sum()) / (points * np.log2(points) * pairs).sum()
        return cls(
            work=work,
            levels=row["share_levels"],
            pairs=pairs[0],
            coarse_pairs=pairs[1] if len(pairs) > 1 else 0.0,
            itemsize=4 if row["precision"] == "single" else 8,
            call=call,
            bandwidth_alone=row["copy_bandwidth"],
        )

    @property
    def bytes_per_point(self):
        """Bytes that an FFT pair moves between memory and caches for each point, at least."""
        d = 0.5  # the last step, in bfloat16
        spectrum = 1  # of rows: half as many complex numbers
        level_1 = 1 / 4  # points of the first coarse level, over those of the grid
        coarser = 1 / 12
        # read g, p, d and z of level 1; write d and the row spectra
        search = 2 + 2 * d + level_1 + spectrum
        columns = 2 * spectrum
        # read row spectra, g, p, d; write g, p; write p, theta and x on level 1
        update = spectrum + 4 + d + 3 * level_1
        # level 1: restrict p and theta, then read p, theta, x, write z; coarser ones: write and
        # read p and theta both ways, z
        sweep = 6 * level_1 + 8 * coarser
        return self.itemsize * (search + columns + update + sweep)


def _points_and_pairs(row):
    """Return the points of every grid of a solve, and the FFT pairs on it."""
    points = np.array([share.points for share in _shares(row["n"], 1)], float)
    fine_pairs = min(row["iterations"] + START_AND_END, row["fft_pairs"])
    coarse_pairs = (row["fft_pairs"] - fine_pairs) * points[0] / max(points[1:].sum(), 1)
    return points, np.array([fine_pairs, *[coarse_pairs] * (len(points) - 1)])


@cache
def _shares(n, ranks, itemsize=4, per_node=1):
    """Return what rank 0 has of a grid and of all coarser grids of the nested start."""
    finest = share_of((n, n), np.float32 if itemsize == 4 else np.float64, ranks, per_node=per_node)
    return [finest, *(Share(grid, finest.dtype) for grid in finest.grids)]


def _pair(share, machine):
    """Predict the seconds of an FFT pair on a grid: compute, transpose, levels and reductions."""
    ranks_of_node = len(share.grid.comm.node_ranks)  # those with a part of the grid
    alone = machine.work * np.log2(share.grid.cell_points)
    memory = machine.bytes_per_point / machine.bandwidth_alone
    shared_memory = machine.bytes_per_point * ranks_of_node / machine.bandwidth
    gathered_points = max(share.level_points - share.points / 3, 0.0)
    compute = share.points * (max(alone - memory, 0.0) + max(memory, shared_memory))
    compute += machine.call + gathered_points * 3 * machine.levels * alone

    nbytes, messages = transpose_traffic(share.layout)
    transpose = nbytes * ranks_of_node / machine.link + messages * machine.overhead
    transpose += 2 * share.layout.blocks_per_rank * machine.latency * (messages > 0)
    transpose += 2 * machine.barrier * stages(ranks_of_node)

    level_bytes, level_messages = share.level_traffic
    levels = level_bytes / machine.link + level_messages * machine.halo
    levels += (level_messages + share.reduction_traffic[1]) * machine.latency
    return np.array([compute, transpose, levels])


def _solve(n, ranks, machine):
    """Predict the seconds of the same parts of a solve."""
    shares = _shares(n, ranks, machine.itemsize, machine.cores)
    finest, *coarser = (_pair(share, machine) for share in shares)
    return machine.pairs * finest + machine.coarse_pairs * sum(coarser, np.zeros(3))


def predict(n, nodes, machine):
    """Predict a solve on full nodes of a cluster.

    Parameters
    ----------
    n : int
        Points along an axis.
    nodes : int
        Number of nodes.
    machine : Machine
        Costs.

    Returns
    -------
    dict or None
        Seconds, efficiency against one full node (of_one_node), the shares of transposes and of
        the messages of levels and reductions (share_others), and the part of the nodes' memory
        bandwidth that is used. None if there are more ranks than rows.
    """
    if nodes * machine.cores > n:
        return None
    parts = _solve(n, nodes * machine.cores, machine)
    one_node = _solve(n, machine.cores, machine)
    moved_bytes = n * n * machine.bytes_per_point * (machine.pairs + machine.coarse_pairs / 3)
    return {
        "n": n,
        "nodes": nodes,
        "link_gb_per_s": machine.link / 1e9,
        "seconds": float(parts.sum()),
        "of_one_node": float(one_node.sum() / (parts.sum() * nodes)),
        "share_transpose": float(parts[1] / parts.sum()),
        "share_others": float(parts[2] / parts.sum()),
        "of_bandwidth": float(moved_bytes / nodes / machine.bandwidth / parts.sum()),
    }
