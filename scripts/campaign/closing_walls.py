"""Families near full contact."""

import numpy as np

from .registry import Wall, family, load_of_area, nearly_closed, scene_wall, single
from .shapes import choice, grid, log_uniform, rough, square_pixels


@family
def near_full(rng):
    return single(rng, rough(rng, grid(rng)), low=0.4, high=20)


@family
def near_full_closing(rng):
    """The last open points, which random loads rarely reach."""
    n = grid(rng)
    z = rough(rng, n)
    return Wall(z, square_pixels(n), (load_of_area(z, 1 - log_uniform(rng, 2 / z.size, 0.05)),))


@family
def next_to_closing(rng):
    """A load 1e-9 to 1e-6 below that of full contact, where the last points are hardly open."""
    z = rough(rng, grid(rng)) if rng.random() < 0.7 else rng.standard_normal(grid(rng))
    return nearly_closed(rng, z, 1e-9, 1e-6)


@family
def near_full_skewed(rng):
    z = rough(rng, grid(rng))
    s = choice(rng, (-1, 1)) * rng.uniform(0.1, 0.8)
    return single(rng, z + s * z * z, low=0.4, high=20)


@family
def high_pressure(rng):
    z = (
        rough(rng, grid(rng))
        if rng.random() < 0.5
        else -np.exp(rng.uniform(0.5, 2.5) * rough(rng, grid(rng)))
    )
    return single(rng, z, low=1, high=100)


@family
def smooth_near_full(rng):
    """Well-resolved waves of nearly one length, with lam_s/a of 4 to 64."""
    per_wave = choice(rng, (4, 8, 12, 16, 32))
    waves = choice(rng, [k for k in (1, 2, 3, 4, 5, 8) if 32 <= k * per_wave <= 160])
    n = waves * per_wave
    z = rough(rng, (n, n), modes=(waves, waves * choice(rng, (1, 1, 1.5, 2))))
    return single(rng, z, low=0.3, high=1.2)


@family
def smooth_near_full_large(rng):
    per_wave, waves = choice(rng, ((32, 8), (64, 4), (64, 5), (128, 2), (32, 10), (64, 8)))
    n = waves * per_wave
    z = rough(rng, (n, n), hurst=0.93, modes=(waves, waves * choice(rng, (1, 1, 2))))
    return single(rng, z, low=0.3, high=1.2)


@family
def smooth_scene(rng):
    """The same with surfaces of the package, for low memory; the first seed is a hard one."""
    seed = int(choice(rng, (421, *range(1, 60))))
    surface = {
        "kind": "self-affine",
        "hurst": 0.93,
        "L_over_lam_l": 4,
        "lam_l_over_lam_s": 1,
        "lam_s_over_a": choice(rng, (8, 16, 32)),
        "seed": seed,
    }
    p_star = 0.836 if rng.random() < 0.2 else log_uniform(rng, 0.4, 1.1)
    return scene_wall(surface, (p_star,))
