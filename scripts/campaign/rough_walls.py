"""Families of roughness of all kinds, also with spikes and pits."""

import numpy as np

from .registry import family, single
from .shapes import (
    ODDS,
    PRIMES,
    choice,
    coordinates,
    distances,
    frequencies,
    grid,
    log_uniform,
    rough,
    square_pixels,
)


@family
def self_affine(rng):
    return single(rng, rough(rng, grid(rng)))


@family
def self_affine_smooth(rng):
    n = grid(rng)
    low = rng.uniform(1, 3)
    return single(rng, rough(rng, n, modes=(low, max(1.5 * low, n[0] / log_uniform(rng, 6, 20)))))


@family
def roll_off(rng):
    return single(rng, rough(rng, grid(rng), roll_off=rng.uniform(2, 5)))


@family
def prime_grid(rng):
    n = choice(rng, PRIMES), choice(rng, PRIMES[:3])
    return single(rng, rough(rng, n if rng.random() < 0.5 else (n[0], n[0])))


@family
def odd_grid(rng):
    n = choice(rng, ODDS)
    return single(rng, rough(rng, (n, n if rng.random() < 0.5 else 64)))


@family
def long_cell(rng):
    n = choice(rng, ((512, 32), (32, 512), (640, 40), (40, 640), (1024, 64)))
    return single(rng, rough(rng, n))


@family
def thin_pixels(rng):
    n = grid(rng)
    ratio = choice(rng, (1 / 16, 16, 1 / 4, 4, 1.5))
    sizes = (1.0, n[1] / n[0] * ratio)
    return single(rng, rough(rng, n, sizes), sizes)


@family
def thin_pixels_noise(rng):
    n = grid(rng)
    return single(rng, rng.standard_normal(n), (1.0, n[1] / n[0] * choice(rng, (1 / 16, 16))))


@family
def anisotropic(rng):
    return single(rng, rough(rng, grid(rng), stretch=choice(rng, (1 / 16, 1 / 4, 4, 16))))


@family
def white_noise(rng):
    return single(rng, rng.standard_normal(grid(rng)), high=3.0)


@family
def two_scales(rng):
    n = grid(rng)
    z = rough(rng, n, modes=(1, 4)) + log_uniform(rng, 1e-3, 0.3) * rough(
        rng, n, modes=(n[0] / 8, n[0] / 3)
    )
    return single(rng, z)


@family
def long_mode(rng):
    """One long wave and little roughness, whose error decreases slowly."""
    n = grid(rng)
    x, y = coordinates(n, (1, 1))
    k = choice(rng, ((1, 0), (0, 1), (1, 1)))
    z = np.cos(2 * np.pi * (k[0] * x + k[1] * y)) + log_uniform(rng, 1e-4, 0.1) * rough(rng, n)
    return single(rng, z, low=1e-4)


@family
def quantised(rng):
    return single(rng, np.round(rough(rng, grid(rng)) * choice(rng, (1, 2, 4, 16))))


@family
def offset(rng):
    return single(rng, rough(rng, grid(rng)) + rng.choice([-1, 1]) * log_uniform(rng, 1e2, 1e6))


@family
def heavy_tails(rng):
    n = grid(rng)
    z = rng.standard_t(choice(rng, (1.5, 2, 3)), n)
    k = frequencies(n, square_pixels(n))
    return single(rng, np.fft.ifft2(np.fft.fft2(z) * np.maximum(k, 1) ** -rng.uniform(0, 1.5)).real)


@family
def exponential(rng):
    return single(rng, np.exp(rng.uniform(0.3, 2) * rough(rng, grid(rng))), low=1e-4)


@family
def minus_exponential(rng):
    return single(rng, -np.exp(rng.uniform(0.3, 2) * rough(rng, grid(rng))), high=3.0)


@family
def plateaus(rng):
    z = rough(rng, grid(rng))
    return single(rng, np.minimum(z, np.quantile(z, rng.uniform(0.4, 0.95))))


@family
def honed(rng):
    n = grid(rng)
    x, y = coordinates(n, square_pixels(n))
    z = 0.2 * rough(rng, n)
    for slope in (1, -1):
        for _ in range(rng.integers(2, 6)):
            phase = (x + slope * choice(rng, (1, 2)) * y * n[0] / n[1] + rng.random()) % 1.0
            z = z - rng.uniform(0.5, 2) * np.exp(-(((phase - 0.5) * n[0] / rng.uniform(1, 4)) ** 2))
    return single(rng, z)


@family
def steps(rng):
    n = grid(rng)
    x, y = coordinates(n, (1, 1))
    z = choice(rng, (0.0, 0.05, 0.3)) * rough(rng, n)
    for _ in range(rng.integers(1, 6)):
        angle = rng.uniform(0, np.pi)
        z = z + rng.uniform(0.2, 1) * (
            np.cos(angle) * x + np.sin(angle) * y > rng.uniform(-0.4, 0.4)
        )
    return single(rng, z)


@family
def telegraph(rng):
    n = grid(rng)
    z = (rough(rng, n, hurst=rng.uniform(0, 0.8)) > rng.uniform(-0.5, 1.5)).astype(float)
    return single(rng, z + choice(rng, (0.0, 1e-3, 0.05)) * rough(rng, n))


@family
def rough_large(rng):
    n = choice(rng, (256, 320, 243))
    return single(rng, rough(rng, (n, n)))


@family
def strip(rng):
    n = choice(rng, ((4, 1000), (1000, 4), (8, 512), (3, 729), (2, 1024)))
    return single(rng, rough(rng, n))


@family
def few_rows_noise(rng):
    return single(rng, rng.standard_normal(choice(rng, ((4, 1000), (1000, 4), (5, 500)))))


@family
def ridges(rng):
    """Nearly one-dimensional heights, slightly rough along the other axis."""
    n = choice(rng, ((64, 64), (128, 128), (100, 100), (256, 32), (32, 256), (512, 16)))
    axis = int(rng.integers(2))
    line = rough(rng, (n[axis], 1), (1.0, 1.0), modes=(1, n[axis] / rng.uniform(2, 8)))
    z = (line if axis == 0 else line.T) + log_uniform(rng, 1e-5, 0.1) * rough(rng, n)
    return single(rng, z)


@family
def tiny(rng):
    """Grids of very few points, also along one axis only."""
    n = choice(
        rng, ((2, 2), (3, 3), (1, 64), (97, 1), (2, 31), (5, 4), (8, 8), (16, 16), (1, 1000))
    )
    return single(
        rng,
        rng.standard_normal(n) if rng.random() < 0.5 else np.exp(rng.standard_normal(n)),
        low=1e-4,
        high=3,
    )


@family
def spike(rng):
    n = grid(rng)
    z = log_uniform(rng, 1e-3, 1) * rough(rng, n)
    z[tuple(rng.integers(n))] += log_uniform(rng, 1, 100)
    return single(rng, z, low=1e-5)


@family
def spikes(rng):
    n = grid(rng)
    z = log_uniform(rng, 1e-3, 1) * rough(rng, n)
    for _ in range(rng.integers(2, 40)):
        z[tuple(rng.integers(n))] += log_uniform(rng, 0.3, 10)
    return single(rng, z, low=1e-5)


@family
def dust(rng):
    """Small hemispheres on a rough wall."""
    n = grid(rng)
    sizes = square_pixels(n)
    z = log_uniform(rng, 0.01, 1) * rough(rng, n)
    for dx, dy in distances(rng, n, sizes, int(rng.integers(1, 30))):
        radius = log_uniform(rng, 1.5, 8) / n[0]
        z = z + log_uniform(rng, 0.3, 5) * np.sqrt(np.maximum(1 - (dx**2 + dy**2) / radius**2, 0))
    return single(rng, z, low=1e-4)


@family
def pits(rng):
    n = grid(rng)
    z = choice(rng, (0.0, 0.01, 0.1)) * rough(rng, n)
    for _ in range(rng.integers(1, 20)):
        z[tuple(rng.integers(n))] -= log_uniform(rng, 0.1, 10)
    return single(rng, z, low=1e-2, high=3)
