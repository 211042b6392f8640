"""Families of yielding flat tops: terraces, pins, plateaus, random steps, and soft roughness.

The hardness is 1e-5 to 10 times E* g_rms. Loads differ by a relative 1e-6 to 0.1 from what the
terraces carry at the hardness, where all elastic points are about to yield, or are anywhere below
the hardness.
"""

import numpy as np

from .registry import Wall, family
from .shapes import choice, distances, log_uniform, rough, square_pixels

LOADS = 8
SIDES = (24, 32, 48, 64, 80)
SOFTEST = 1e-5
HARDEST = 10.0


def _pressed(rng, z):
    """Return a wall with a hardness and loads near its plastic limits."""
    hardness = log_uniform(rng, SOFTEST, HARDEST)
    _, counts = np.unique(-z, return_counts=True)
    carried = np.cumsum(counts) / z.size
    loads = []
    for _ in range(LOADS):
        share = float(choice(rng, carried)) if rng.random() < 0.75 else log_uniform(rng, 1e-3, 1)
        distance = log_uniform(rng, 1e-6, 0.1)
        is_below = share * (1 + distance) >= 1 or rng.random() < 0.5
        loads.append(hardness * share * (1 - distance if is_below else 1 + distance))
    return Wall(z, square_pixels(z.shape), tuple(loads), hardness_star=hardness)


def _square(rng):
    n = choice(rng, SIDES)
    return n, n


def _long_waves(rng, n):
    """Return heights with waves of at least four points."""
    return rough(rng, n, hurst=0.8, modes=(1, n[0] / 4))


@family
def plastic_terraces(rng):
    levels = int(rng.integers(2, 10))
    return _pressed(rng, np.floor(_long_waves(rng, _square(rng)) * levels) / levels)


@family
def plastic_pins(rng):
    """Square pins of equal or different heights on a plate."""
    n = choice(rng, (32, 48, 64, 96))
    step = choice(rng, (8, 16))
    width = int(rng.integers(1, step // 2 + 1))
    on_pin = (np.arange(n) % step) < width
    spread = choice(rng, (0, 0, 1e-6, 1e-3, 0.1))
    tops = 1 + spread * rng.standard_normal((n // step, n // step))
    z = np.kron(tops, np.ones((step, step))) * np.outer(on_pin, on_pin)
    return _pressed(rng, z)


@family
def plastic_plateaus(rng):
    z = _long_waves(rng, _square(rng))
    return _pressed(rng, np.minimum(z, rng.uniform(-1, 1.5)))


@family
def plastic_bits(rng):
    """Steps of 1, 1/2, 1/4, ... of a height, each where another rough field is positive."""
    n = _square(rng)
    z = np.zeros(n)
    for k in range(int(rng.integers(1, 6))):
        z += 2.0**-k * (rough(rng, n, hurst=0.5, modes=(1, n[0] / 4)) > 0)
    return _pressed(rng, z + (z.max() == z.min()) * np.eye(*n))


@family
def plastic_cantor(rng):
    """Terraces on terraces: the middle third is lower, recursively."""
    n = choice(rng, (27, 54, 81))
    depth = int(rng.integers(2, 4))
    z = np.zeros((n, n))
    for k in range(depth):
        is_high = (np.arange(n) // (n // 3 ** (k + 1))) % 3 != 1
        z += 2.0**-k * np.outer(is_high, is_high)
    return _pressed(rng, z)


@family
def plastic_ridges(rng):
    """A ridge, plate or disc on a plane."""
    n = choice(rng, SIDES)
    x = np.arange(n) - n // 2
    r = rng.uniform(1, n / 2)
    shape = choice(rng, ("ridge", "square", "disc"))
    high = {
        "ridge": (np.abs(x) < r)[:, None] & (np.abs(x) < n),
        "square": (np.abs(x) < r)[:, None] & (np.abs(x) < r),
        "disc": np.hypot(x[:, None], x) < r,
    }[shape]
    high[0, 0] = False
    return _pressed(rng, 1.0 * high)


@family
def plastic_steps(rng):
    """Plates of different heights on top of each other."""
    n = _square(rng)
    z = np.zeros(n)
    for dx, dy in distances(rng, n, (1, 1), int(rng.integers(2, 12))):
        inside = (dx < rng.uniform(0.03, 0.25)) & (dy < rng.uniform(0.03, 0.25))
        z += log_uniform(rng, 1e-3, 1) * inside
    return _pressed(rng, z + (z.max() == z.min()) * np.eye(*n))


@family
def plastic_rough(rng):
    return _pressed(rng, rough(rng, _square(rng)))


@family
def plastic_smooth(rng):
    n = _square(rng)
    return _pressed(rng, rough(rng, n, hurst=0.8, modes=(2, n[0] / 8)))


@family
def plastic_noise(rng):
    return _pressed(rng, rng.standard_normal(_square(rng)))
