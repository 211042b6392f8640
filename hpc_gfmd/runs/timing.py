"""How long a scene will take, from a measurement of a few seconds that is kept in the user's
cache."""

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
BASELINE_PAIRS = {"gfmd": 150.0}


@dataclass(frozen=True)
class Pairs:
    """FFT pairs of the default solver to an accuracy of 1e-3, everything counted; further ones per
    decade; searching: times as many where the mean pressures have to be found."""

    each: float = 9.0
    per_decade: float = 2.8
    searching: float = 1.5


def expected_pairs(scene: Scene) -> float:
    """Estimate the FFT pairs of each load of a scene."""
    settings, known = scene.solver, Pairs()
    decades = -np.log10(settings.tolerance) - 3
    each = BASELINE_PAIRS.get(settings.name, known.each)
    each *= max(0.6, 1 + decades * known.per_decade / known.each)
    return each * (known.searching if scene.load.found else 1)


def expected_seconds(
    pairs: float, precisions: Iterable[np.dtype | None], cell: tuple[int, int]
) -> float:
    """Estimate the seconds of solving loads on one core of this machine. pairs: FFT pairs of each
    load; precisions: of all loads; cell: points that are solved."""
    points = float(np.prod(cell))
    work = points * np.log2(max(points, 2))
    once = cache(seconds_per_work)  # what cannot be kept would be measured for each load
    return float(pairs * work * sum(map(once, precisions)))


@dataclass(frozen=True)
class Cluster:
    """Assumed nodes, and what a solve takes on them: a model without waiting, rather fast.

    cores: of a node; together: how many times as fast as one core its memory lets them be (16 cores
    here: 8); bandwidth: bytes per second of its link, latency: seconds of a message, the work for
    it included (InfiniBand of 100 Gbit/s as makers tell, and 16 ranks here)."""

    cores: int = 64
    together: float = 10.0
    bandwidth: float = 12.5e9
    latency: float = 40e-6

    def seconds(self, alone: float, pairs: float, traffic: tuple[int, int], ranks: int) -> float:
        """Model the seconds of a solve on `ranks` of its cores that takes so many seconds on one
        core here; traffic: (bytes, messages) that a rank sends in an FFT pair."""
        nodes = -(-ranks // self.cores)
        nbytes, messages = traffic
        sent = nbytes * (ranks / nodes) / self.bandwidth * (nodes > 1) + messages * self.latency
        return alone / min(ranks, nodes * self.together) + pairs * sent


def seconds_per_work(dtype: DTypeLike) -> float:
    """Return the seconds per FFT pair (with everything that goes along with it) and N log2 N;
    measured once, then read."""
    folder = cache_folder()
    path = folder and folder / f"speed-{np.dtype(dtype).name}-{platform.node()}"
    if path and (content := kept(path)):
        return float(content)
    seconds = _measure(dtype)
    if path:
        keep(path, str(seconds).encode())
    return seconds


def _measure(dtype: DTypeLike) -> float:
    from .prepared import make_surface
    from .solve import solve

    precision = "single" if np.dtype(dtype) == np.float32 else "double"
    wall, best = make_surface(**SAMPLE), np.inf
    for p_star in (0.05, 0.4, 0.01):
        begun = time.perf_counter()
        pairs = solve(wall, p_star=p_star, precision=precision, fields=(), threads=1).fft_pairs
        best = min(best, (time.perf_counter() - begun) / pairs)
    N = wall.heights.size
    return best / (N * np.log2(N))
