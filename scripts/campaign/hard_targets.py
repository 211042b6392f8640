"""Families with a hardness and prescribed areas or mean gaps, from three points to 64 x 64, and
waves."""

import numpy as np

from .registry import family
from .shapes import choice, log_uniform
from .target_walls import with_targets

SHAPES = ((1, 3), (3, 1), (2, 2), (1, 16), (3, 3), (5, 7), (8, 8), (1, 64), (16, 16), (64, 64))
TARGETS = 2
SOFTEST = 0.02  # hardness over E* g_rms
HARDEST = 300.0


def _heights(rng):
    n = choice(rng, SHAPES)
    x, y = (2 * np.pi * np.arange(k) / k for k in n)
    if rng.random() < 0.5 and min(n) > 1:
        return np.add.outer(np.cos(x), np.cos(y * int(rng.integers(0, 3))))
    return rng.standard_normal(n)


def _hard(rng, z, quantity, values):
    hardness = log_uniform(rng, SOFTEST, HARDEST)
    return with_targets(z, quantity, values, hardness_star=hardness)


@family
def target_hard_area(rng):
    z = _heights(rng)
    shares = (1 - log_uniform(rng, 1e-3, 0.9) for _ in range(TARGETS))
    return _hard(rng, z, "a_r", (max(share, 0.6 / z.size) for share in shares))


@family
def target_hard_gap(rng):
    z = _heights(rng)
    largest = (z.max() - z.mean()) / z.std()
    gaps = (log_uniform(rng, 1e-6, 0.9) * largest for _ in range(TARGETS))
    return _hard(rng, z, "gap_over_h_rms", gaps)
