"""How long a scene will take, from a measurement of a few seconds that is kept in the user's
cache."""

import json
import os
import time

import numpy as np
from numpy.typing import DTypeLike

from ..driver.precision import first_precision
from ..driver.sweep import Sweep
from ..scene import Scene
from ..util.caches import cache_folder, keep

SAMPLE = {
    "kind": "self-affine",
    "hurst": 0.8,
    "L_over_lam_l": 2,
    "lam_l_over_lam_s": 256,
    "lam_s_over_a": 2,
    "seed": 1,
}
# FFT pairs to an accuracy of 1e-3, everything counted, and further ones per decade, for the default
# solver
PAIRS, PAIRS_PER_DECADE = 9.0, 2.8
SEARCHING = 1.5  # times as many where the mean pressures have to be found
BASELINE_PAIRS = {"gfmd": 150.0, "fire": 400.0, "ccg": 150.0}


def expected_seconds(scene: Scene, n: tuple[int, int], ranks: int, cores: int) -> float:
    """Seconds of solving all loads of a scene on `ranks` ranks that share `cores` cores of this
    machine."""
    settings = scene.solver
    decades = -np.log10(settings.tolerance) - 3
    pairs = BASELINE_PAIRS.get(settings.name, PAIRS) * max(
        0.6, 1 + decades * PAIRS_PER_DECADE / PAIRS
    )
    points = n[0] * n[1]
    work = points * np.log2(max(points, 2))
    loads = len(scene.load.given[1]) * (SEARCHING if scene.load.found else 1.0)
    return float(
        loads * pairs * work * seconds_per_work(first_precision(settings)) / min(ranks, cores)
    )


def seconds_per_work(dtype: DTypeLike) -> float:
    """Seconds per FFT pair (with everything that goes along with it) and N log2 N; measured once,
    then read."""
    path = cache_folder() / f"speed-{np.dtype(dtype).name}.json"
    try:
        known = json.loads(path.read_text())
        if known["host"] == os.uname().nodename:
            return float(known["seconds_per_work"])
    except (OSError, ValueError, KeyError, TypeError):
        pass
    value = _measure(dtype)
    keep(
        path,
        json.dumps(
            {"host": os.uname().nodename, "seconds_per_work": value, "time": time.time()}
        ).encode(),
    )
    return value


def _measure(dtype: DTypeLike) -> float:
    from ..parallel.comm import SerialComm
    from ..surface import build_surface

    precision = "single" if np.dtype(dtype) == np.float32 else "double"
    scene = Scene.from_dict(
        {"surface": SAMPLE, "load": {"p_star": 0.05}, "solver": {"precision": precision}}
    )
    sweep = Sweep(lambda d: build_surface(scene.surface, SerialComm(), d), scene.solver)
    best = np.inf
    for p_star in (0.05, 0.4, 0.01):  # far apart: each starts anew
        begun = time.perf_counter()
        step = sweep.solve(p_star * sweep.surface.g_rms)
        best = min(best, (time.perf_counter() - begun) / step.fft_pairs)
    N = sweep.surface.grid.N
    return best / (N * np.log2(N))
