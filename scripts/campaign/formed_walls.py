"""Families of punches, indenters and perfectly ordered walls."""

import numpy as np

from .registry import FAMILIES, Wall, family, scene_wall, single
from .shapes import choice, coordinates, distances, grid, log_uniform, pixels, rough, square_pixels


@family
def punch_square(rng):
    n = grid(rng)
    x, y = coordinates(n, (1, 1))
    a, b = rng.uniform(0.1, 0.45, 2)
    return single(rng, 1.0 * ((np.abs(x) < a) & (np.abs(y) < b)), pixels(rng, n), low=1e-4)


@family
def punch_round(rng):
    n = grid(rng)
    x, y = coordinates(n, square_pixels(n))
    return single(
        rng, 1.0 * (np.hypot(x, y) < rng.uniform(0.1, 0.45) * min(1, n[1] / n[0])), low=1e-4
    )


@family
def punches(rng):
    """Several punches of different heights, perhaps tilted or rough."""
    n = grid(rng)
    x, y = coordinates(n, (1, 1))
    z = np.zeros(n)
    for dx, dy in distances(rng, n, (1, 1), int(rng.integers(2, 12))):
        inside = (dx < rng.uniform(0.03, 0.15)) & (dy < rng.uniform(0.03, 0.15))
        z = np.where(inside, 1 + log_uniform(rng, 1e-3, 0.3), z)
    z = (
        z
        + choice(rng, (0, 1e-3, 0.05)) * (x * (z > 0) + 0 * y)
        + choice(rng, (0, 1e-3, 0.02)) * rough(rng, n)
    )
    return single(rng, z, low=1e-4)


def _indenter(shape):
    def make_wall(rng):
        n = grid(rng)
        sizes = pixels(rng, n)
        x, y = coordinates(n, sizes)
        shift = rng.random(2) / n if rng.random() < 0.5 else (0, 0)
        return single(rng, shape(x + shift[0], y + shift[1]), sizes, low=1e-4)

    return make_wall


for _name, _shape in {
    "sphere": lambda x, y: -(x**2 + y**2),
    "cone": lambda x, y: -np.hypot(x, y),
    "wedge": lambda x, y: -np.abs(x) + 0 * y,
    "pyramid": lambda x, y: -np.maximum(np.abs(x), np.abs(y)),
    "cylinder": lambda x, y: -(y**2) + 0 * x,
    "ellipsoid": lambda x, y: -(x**2 + 30 * y**2),
}.items():
    FAMILIES[_name] = _indenter(_shape)


@family
def rough_sphere(rng):
    n = grid(rng)
    x, y = coordinates(n, square_pixels(n))
    return single(rng, -(x**2 + y**2) + log_uniform(rng, 1e-4, 0.03) * rough(rng, n), low=1e-4)


@family
def sines(rng):
    n = grid(rng)
    x, y = coordinates(n, (1, 1))
    kx = int(rng.integers(0, 4))
    ky = int(rng.integers(1, 4))
    z = (
        np.cos(2 * np.pi * kx * x) * np.cos(2 * np.pi * ky * y)
        if rng.random() < 0.5
        else (np.cos(2 * np.pi * kx * x) + rng.uniform(0.1, 1) * np.cos(2 * np.pi * ky * y))
    )
    return single(rng, z + 0 * x * y)


WAVES = (
    (100, 5),
    (128, 4),
    (96, 6),
    (64, 4),
    (120, 8),
    (72, 6),
    (160, 10),
    (128, 8),
    (81, 9),
    (105, 5),
)
HARD_WAVES = ((100, 5, 0.02432), (100, 5, 0.0708), (128, 4, 0.1155), (128, 4, 0.2061))


def wave_heights(n, k):
    """Return cos x cos y with k periods along each axis."""
    c = np.cos(2 * np.pi * ((k * np.arange(n)) % n) / n)
    return np.outer(c, c)


@family
def wave(rng):
    """A perfectly ordered wave."""
    n, k = choice(rng, WAVES)
    return single(rng, wave_heights(n, k), pixels(rng, (n, n)), low=3e-3, high=0.6)


LATTICES = (
    (72, 12),
    (128, 16),
    (96, 12),
    (96, 16),
    (144, 12),
    (64, 8),
    (100, 10),
    (120, 24),
    (120, 20),
)


def lattice_heights(n, d):
    """Return equal paraboloids with a period of d points."""
    x = (np.arange(n) % d - d // 2) / d
    return -(x[:, None] ** 2 + x[None, :] ** 2)


@family
def lattice(rng):
    """A lattice of equal paraboloids."""
    n, d = choice(rng, LATTICES)
    return single(rng, lattice_heights(n, d), pixels(rng, (n, n)), low=3e-3, high=0.6)


@family
def lattice_noise(rng):
    z = lattice_heights(*choice(rng, LATTICES))
    return single(
        rng, z + log_uniform(rng, 1e-8, 0.03) * rng.standard_normal(z.shape), low=1e-3, high=0.6
    )


@family
def wave_noise(rng):
    z = wave_heights(*choice(rng, WAVES))
    return single(rng, z + log_uniform(rng, 1e-8, 0.03) * rough(rng, z.shape), low=1e-3, high=0.6)


@family
def checkerboard(rng):
    n, d = choice(rng, ((64, 8), (96, 12), (128, 16), (120, 10), (96, 4)))
    i = np.arange(n) // d % 2
    z = 1.0 * (i[:, None] ^ i[None, :])
    return single(rng, z + choice(rng, (0, 1e-4, 1e-2)) * rough(rng, (n, n)))


@family
def replicas(rng):
    """A small rough cell, repeated: every event happens in all copies at once."""
    m, copies = choice(rng, ((16, 4), (16, 6), (20, 5), (32, 4), (12, 8)))
    return single(rng, np.tile(rough(rng, (m, m), modes=(1, m / 2.5)), (copies, copies)))


@family
def known(rng):
    """Walls and loads that are known to be hard."""
    if rng.random() < 0.3:
        return scene_wall(
            {
                "kind": "self-affine",
                "hurst": 0.93,
                "L_over_lam_l": 4,
                "lam_l_over_lam_s": 1,
                "lam_s_over_a": 32,
                "seed": 421,
            },
            (0.836 * np.exp(rng.uniform(-0.01, 0.01)),),
        )
    n, k, p_star = choice(rng, HARD_WAVES)
    return Wall(
        wave_heights(n, k),
        (1.0, 1.0),
        (p_star * float(np.exp(rng.choice([0, 0.01]) * rng.uniform(-1, 1))),),
    )
