"""The loosest tolerance of a code whose true error is still small enough."""

import time
from collections.abc import Callable

import numpy as np

TRIES = 10
PATIENCE = 3  # times the budget that is spent where nothing is good enough yet
CLOSE = 1.5  # ratio of a tolerance that fails to one that passes at which the search ends


def loosest(
    error_at: Callable[[float], float], target: float, start: float, budget: float = np.inf
) -> tuple[float | None, float]:
    """The loosest tolerance t with error_at(t) <= target, and that error; (None, smallest error
    found) where there is none.

    Steps proportionally to the error until the answer is bracketed, then bisects; ends after
    `budget` seconds at the best known.
    """
    begun = time.perf_counter()
    passes: float | None = None
    fails: float | None = None
    best = np.inf  # error of what passes
    lowest = np.inf
    tolerance = start
    for _ in range(TRIES):
        error = error_at(tolerance)
        lowest = min(lowest, error)
        step = 0.7 * target / max(error, 1e-300)
        if error <= target:
            passes, best = tolerance, error
        else:
            fails = tolerance
        if passes and fails and fails / passes < CLOSE:
            break
        if time.perf_counter() - begun > (budget if passes else PATIENCE * budget):
            break
        if passes and fails:
            tolerance = float(np.sqrt(passes * fails))
        else:
            tolerance *= float(np.clip(step, 2.0, 30.0) if passes else np.clip(step, 1e-2, 0.5))
        if tolerance > 0.5:
            break
    return (passes, best) if passes else (None, lowest)
