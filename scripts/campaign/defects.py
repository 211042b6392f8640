"""Families of walls with defects and of nearly ordered walls: single pits and peaks, plates, nearly
equal bumps, strips."""

import numpy as np

from .registry import at_a_change_of_sides, family, nearly_closed, single, with_random_steps
from .shapes import choice, grid, log_uniform, rough

BELOW_CLOSING = 1e-6, 0.3  # range of the loads below that of full contact


@family
def plate_with_a_pit(rng):
    n = choice(rng, (32, 64, 100, 127, 128, 200))
    z = np.zeros((n, n))
    z[tuple(rng.integers(n, size=2))] = -log_uniform(rng, 1e-3, 10)
    return nearly_closed(rng, z, *BELOW_CLOSING)


@family
def plate_with_pits(rng):
    """Several pits, equal or not, one or a few points wide, in rows or at random."""
    n = choice(rng, (64, 96, 128))
    z = np.zeros((n, n))
    step = choice(rng, (8, 16, 32))
    places = [(i, j) for i in range(0, n, step) for j in range(0, n, step)]
    if rng.random() < 0.5:
        places = rng.integers(n - 4, size=(int(rng.integers(2, 20)), 2))
    width = choice(rng, (1, 1, 2, 4))
    spread = choice(rng, (0, 0, 1e-4, 0.3))
    for i, j in places:
        z[i : i + width, j : j + width] = -1 - spread * rng.standard_normal()
    return nearly_closed(rng, z, *BELOW_CLOSING)


@family
def plate_with_a_groove(rng):
    n = grid(rng)
    z = choice(rng, (0, 1e-6, 1e-3)) * rough(rng, n)
    z[:, int(rng.integers(n[1]))] -= 1
    return nearly_closed(rng, z, *BELOW_CLOSING)


@family
def rough_with_a_pit(rng):
    z = rough(rng, grid(rng))
    for _ in range(choice(rng, (1, 1, 3))):
        z[tuple(rng.integers(z.shape))] -= log_uniform(rng, 3, 300)
    return nearly_closed(rng, z, *BELOW_CLOSING)


def hexagonal_heights(rng, n, count, jitter, spread):
    """Return round bumps on a hexagonal lattice: n points along an axis and `count` bumps along x,
    whose places scatter by `jitter` over their distance and whose heights by `spread`."""
    rows = 2 * round(count / np.sqrt(3))
    x = np.arange(n) / n
    z = np.full((n, n), -np.inf)
    for i in range(count):
        for j in range(rows):
            centre = (i + 0.5 * (j % 2)) / count, j / rows
            dx, dy = (
                (x - c - jitter / count * rng.standard_normal() + 0.5) % 1 - 0.5 for c in centre
            )
            bump = spread * rng.standard_normal() - count**2 * (dx[:, None] ** 2 + dy**2)
            z = np.maximum(z, bump)
    return z


@family
def hexagonal(rng):
    """A load near which equal bumps change sides."""
    n, count = choice(rng, ((96, 8), (72, 6), (128, 10), (64, 4)))
    jitter = choice(rng, (0, 1e-3, 0.02, 0.1))
    spread = choice(rng, (0, 1e-6, 1e-3, 0.03))
    z = hexagonal_heights(rng, n, count, jitter, spread)
    return at_a_change_of_sides(rng, z, log_uniform(rng, 5e-3, 0.5))


@family
def sweep_hexagonal(rng):
    return with_random_steps(rng, hexagonal(rng), 1e-3, 0.3)


@family
def tall_point(rng):
    """One point high above a rough wall, like dust on a scan."""
    n = grid(rng)
    z = rng.standard_normal(n)
    if rng.random() < 0.5:
        z = 0.1 * np.cumsum(z, 0)
    z[tuple(rng.integers(n))] = z.max() + choice(rng, (5, 20, 100))
    return single(rng, z, low=1e-6)


@family
def long_strip(rng):
    """A random walk along a strip of few rows."""
    n = choice(rng, ((3, 3000), (3, 5000), (4, 8000), (1, 10000), (2, 4096)))
    z = np.cumsum(rng.standard_normal(n), 1)
    z -= np.linspace(0, 1, n[1]) * (z[:, -1:] - z[:, :1])
    return single(rng, z, low=1e-4, high=0.3)
