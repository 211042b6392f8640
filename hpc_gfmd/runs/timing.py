"""Forecast of the time of a scene, from the speed of this machine.

The speed is measured for a few seconds and kept in the user's cache.
"""

import platform
import time
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import DTypeLike

from ..scene import Scene
from ..util.caches import cache_folder, keep, kept

SAMPLE: dict[str, Any] = {
    "kind": "self-affine",
    "hurst": 0.8,
    "L_over_lam_l": 2,
    "lam_l_over_lam_s": 256,
    "lam_s_over_a": 2,
    "seed": 1,
}
BASELINE_PAIRS = {"gfmd": 150.0}  # of solvers without a preconditioner


@dataclass(frozen=True)
class Pairs:
    """FFT pairs that the default solver needs, all grids together, in pairs of the finest grid.

    Attributes
    ----------
    per_load : float
        For one load to an accuracy of 1e-3.
    per_decade : float
        For each further decade of accuracy.
    searching : float
        Factor if the mean pressure has to be searched for.
    """

    per_load: float = 9.0
    per_decade: float = 2.8
    searching: float = 1.5


PAIRS = Pairs()


def expected_pairs(scene: Scene) -> float:
    """Return a forecast of the FFT pairs of each load of a scene."""
    decades = -np.log10(scene.solver.tolerance) - 3
    pairs = BASELINE_PAIRS.get(scene.solver.name, PAIRS.per_load)
    pairs *= max(0.6, 1 + decades * PAIRS.per_decade / PAIRS.per_load)
    return pairs * (PAIRS.searching if scene.load.is_searched else 1)


def expected_seconds(
    pairs: float, precisions: Iterable[np.dtype | None], cell: tuple[int, int]
) -> float:
    """Return a forecast of the time of solving loads on one core of this machine, in seconds.

    Measures the speed of this machine if it is not in the user's cache.

    Parameters
    ----------
    pairs : float
        FFT pairs of each load.
    precisions : iterable of dtype
        Precision of each load.
    cell : (int, int)
        Points along each axis of the grid.

    Returns
    -------
    float
        Seconds for all loads.
    """
    points = float(np.prod(cell))
    work = points * np.log2(max(points, 2))
    # where the user's cache cannot be written, one measurement serves all loads
    speed = cache(seconds_per_work)
    return float(pairs * work * sum(map(speed, precisions)))


@dataclass(frozen=True)
class Cluster:
    """A model of the time of a solve on nodes of a cluster; optimistic, as it neglects waiting.

    Attributes
    ----------
    cores : int
        Cores of a node.
    speedup : float
        Speed of all cores of a node over that of one; limited by the bandwidth of its memory (16
        cores of our machine: 8).
    bandwidth : float
        Bytes per second of the link of a node: InfiniBand of 100 Gbit/s, as specified.
    latency : float
        Seconds per message, with the work for it, as measured on 16 ranks.
    """

    cores: int = 64
    speedup: float = 10.0
    bandwidth: float = 12.5e9
    latency: float = 40e-6

    def seconds(self, alone: float, pairs: float, traffic: tuple[int, int], ranks: int) -> float:
        """Return a forecast of the time of a solve, in seconds.

        Parameters
        ----------
        alone : float
            Seconds that it takes on one core of this machine.
        pairs : float
            FFT pairs of all loads.
        traffic : (int, int)
            Bytes and messages that a rank sends in an FFT pair.
        ranks : int
            Number of ranks, one on each core.

        Returns
        -------
        float
            Seconds.
        """
        nodes = -(-ranks // self.cores)
        nbytes, messages = traffic
        sent = nbytes * (ranks / nodes) / self.bandwidth * (nodes > 1) + messages * self.latency
        return alone / min(ranks, nodes * self.speedup) + pairs * sent


def seconds_per_work(dtype: DTypeLike) -> float:
    """Return the seconds of an iteration (one FFT pair) on one core, divided by N log2 N.

    N is the number of points of the grid. Measured once for each precision, stored in the user's
    cache, and read from there later.
    """
    folder = cache_folder()
    path = folder and folder / f"speed-{np.dtype(dtype).name}-{platform.node()}"
    if path and (content := kept(path)):
        return float(content)
    seconds = _measure(dtype)
    if path:
        keep(path, str(seconds).encode())
    return seconds


def _measure(dtype: DTypeLike) -> float:
    """Measure `seconds_per_work` by three solves of a small rough surface; return the best."""
    from .solve import solve
    from .surfaces import make_surface

    precision = "single" if np.dtype(dtype) == np.float32 else "double"
    wall = make_surface(**SAMPLE)
    best = np.inf
    for p_star in (0.05, 0.4, 0.01):
        begun = time.perf_counter()
        pairs = solve(wall, p_star=p_star, precision=precision, fields=(), threads=1).fft_pairs
        best = min(best, (time.perf_counter() - begun) / pairs)
    N = wall.heights.size
    return best / (N * np.log2(N))
