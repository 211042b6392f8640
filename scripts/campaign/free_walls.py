"""Families of walls with free edges, with contact at the edges or away from them, and scans."""

import numpy as np

from .formed_walls import lattice_heights
from .light_loads import scene_surface
from .registry import FAMILIES, family, scene_wall, single, with_random_steps
from .shapes import choice, coordinates, distances, log_uniform, rough

GRIDS = (
    (24, 24),
    (32, 32),
    (37, 37),
    (45, 45),
    (48, 48),
    (64, 64),
    (72, 72),
    (80, 80),
    (96, 96),
    (32, 80),
    (96, 40),
    (50, 61),
    (24, 128),
)
ONE_AXIS = ((True, False), (False, True))
BOTH = (True, True)


def with_free_edges(rng, z, sizes=None, free=None, **loads):
    """Return a wall with one load and free edges along both axes or one of them.

    **loads are low and high of `single`.
    """
    free = free or (BOTH if rng.random() < 0.75 else choice(rng, ONE_AXIS))
    return single(rng, z, sizes, free=free, **loads)


def scan(rng, n, crown=0.0):
    """Return a part of a larger rough surface, on a crown of a height over the rms height."""
    m = tuple(k + int(rng.integers(k // 4, k + 1)) for k in n)
    z = rough(rng, m)[: n[0], : n[1]]
    x, y = coordinates(n, (1.0, n[1] / n[0]))
    return z - crown * z.std() * 4 * (x**2 + y**2)


@family
def free_rough(rng):
    return with_free_edges(rng, scan(rng, choice(rng, GRIDS)))


@family
def free_smooth(rng):
    n = choice(rng, GRIDS)
    low = rng.uniform(0.5, 2)
    return with_free_edges(
        rng, rough(rng, n, modes=(low, max(1.5 * low, n[0] / log_uniform(rng, 6, 20))))
    )


@family
def free_crown(rng):
    return with_free_edges(
        rng, scan(rng, choice(rng, GRIDS), crown=log_uniform(rng, 0.3, 10)), free=BOTH
    )


@family
def free_bowl(rng):
    """A bowl, whose edges touch first and whose middle touches last."""
    n = choice(rng, ((96, 96), (112, 112), (128, 128)))
    x, y = coordinates(n, (1.0, n[1] / n[0]))
    z = (
        x**2
        + y**2
        + log_uniform(rng, 1e-4, 0.01) * rough(rng, n, modes=(1, log_uniform(rng, 3, 12)))
    )
    return with_free_edges(rng, z, free=BOTH, low=0.8, high=1.25)


@family
def free_punch(rng):
    """A flat wall or punch, perhaps tilted or rough: the pressure is largest at its edges."""
    n = choice(rng, GRIDS)
    x, y = coordinates(n, (1.0, 1.0))
    a, b = rng.uniform(0.1, 0.6, 2)
    z = -1.0 * ((np.abs(x) > a) | (np.abs(y) > b))
    if rng.random() < 0.4:
        z = 0.0 * z
    z = (
        z
        + choice(rng, (0, 1e-3, 0.02)) * (x + choice(rng, (0, 1, -2)) * y)
        + log_uniform(rng, 1e-4, 0.1) * rough(rng, n)
    )
    return with_free_edges(rng, z, low=1e-3, high=30)


@family
def free_punches(rng):
    n = choice(rng, GRIDS)
    z = np.zeros(n)
    for dx, dy in distances(rng, n, (1, 1), int(rng.integers(2, 9))):
        inside = (dx < rng.uniform(0.05, 0.15)) & (dy < rng.uniform(0.05, 0.15))
        z = np.where(inside, 1 + log_uniform(rng, 1e-3, 0.3), z)
    return with_free_edges(rng, z + choice(rng, (0, 1e-3, 0.02)) * rough(rng, n), low=1e-4)


@family
def free_indenter(rng):
    """One tip at a random place, often closer to an edge than its width."""
    n = choice(rng, GRIDS)
    x, y = coordinates(n, (1.0, n[1] / n[0]))
    x = x - rng.uniform(-0.5, 0.5)
    y = y - rng.uniform(-0.5, 0.5) * n[1] / n[0]
    shape = choice(
        rng, (x**2 + y**2, np.hypot(x, y), np.maximum(np.abs(x), np.abs(y)), x**2 + 20 * y**2)
    )
    return with_free_edges(rng, -shape + choice(rng, (0, 0, 1e-3, 1e-2)) * rough(rng, n), low=1e-4)


@family
def free_lattice(rng):
    """Equal paraboloids, some of them cut off."""
    n, d = choice(rng, ((36, 12), (48, 8), (64, 16), (72, 12), (60, 20), (90, 15)))
    z = lattice_heights(n, d)
    cut = int(rng.integers(0, d)) if rng.random() < 0.5 else 0
    return with_free_edges(
        rng,
        z[cut:, cut:]
        + choice(rng, (0, 1e-8, 1e-4, 1e-2)) * rng.standard_normal(z[cut:, cut:].shape),
        low=3e-3,
    )


@family
def free_one_axis(rng):
    n = choice(rng, GRIDS)
    return with_free_edges(
        rng, choice(rng, (scan(rng, n), rough(rng, n))), free=choice(rng, ONE_AXIS)
    )


@family
def free_measured(rng):
    """Heights as of an instrument, with tilt, form, noise and quantisation."""
    n = choice(rng, GRIDS)
    x, y = coordinates(n, (1.0, n[1] / n[0]))
    z = scan(rng, n)
    z = z + choice(rng, (0, 1, 10)) * (x * rng.standard_normal() + y * rng.standard_normal())
    z = (
        z
        + choice(rng, (0, 0, 3)) * rng.standard_normal() * (x**2 + y**2)
        + choice(rng, (0, 1e-3, 0.03)) * rng.standard_normal(n)
    )
    step = choice(rng, (0, 0, 1e-4, 1e-2))
    return with_free_edges(rng, np.round(z / step) * step if step else z, low=1e-4)


@family
def free_pixels(rng):
    n = choice(rng, ((32, 32), (48, 48), (64, 32), (37, 45)))
    sizes = (1.0, n[1] / n[0] * choice(rng, (1 / 4, 1 / 2, 2, 4)))
    z = rough(rng, n, sizes) if rng.random() < 0.7 else rng.standard_normal(n)
    return with_free_edges(rng, z, sizes)


@family
def free_lines(rng):
    """Few or many lines of a scan that are far apart."""
    n = choice(rng, ((48, 4), (64, 8), (96, 16), (32, 32), (40, 24)))
    sizes = (1.0, n[1] / n[0] * log_uniform(rng, 4, 60))
    z = rough(rng, n, sizes) if rng.random() < 0.7 else rng.standard_normal(n)
    z, sizes = (z, sizes) if rng.random() < 0.5 else (z.T.copy(), sizes[::-1])
    return with_free_edges(rng, z, sizes)


@family
def free_high_load(rng):
    """Most or all of the wall touches."""
    return with_free_edges(
        rng, choice(rng, (scan, rough))(rng, choice(rng, GRIDS)), low=0.5, high=100
    )


@family
def free_few_points(rng):
    n = choice(rng, GRIDS)
    z = scan(rng, n) if rng.random() < 0.7 else rng.standard_normal(n)
    p_star = log_uniform(rng, 2, 60) / z.size / 2
    return with_free_edges(rng, z, low=p_star, high=1.001 * p_star)


@family
def free_scene(rng):
    """Surfaces of the package, which low memory needs."""
    surface = scene_surface(rng) | {
        "boundary": choice(rng, ("free", ["free", "periodic"], ["periodic", "free"]))
    }
    return scene_wall(surface, (log_uniform(rng, 1e-3, 1.5),))


@family
def free_sweep(rng):
    """Several loads, up and down."""
    names = (
        "free_rough",
        "free_crown",
        "free_punch",
        "free_indenter",
        "free_lattice",
        "free_measured",
        "free_high_load",
        "free_scene",
    )
    return with_random_steps(rng, FAMILIES[choice(rng, names)](rng), 0.005, 0.5)
