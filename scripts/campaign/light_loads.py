"""Families of few contact points, of loads near a change of sides, of extreme units, and of scenes
of the package."""

from dataclasses import replace

import numpy as np

from .formed_walls import lattice_heights, wave_heights
from .registry import (
    FAMILIES,
    Wall,
    at_a_change_of_sides,
    change_of_sides_near,
    family,
    load_of_area,
    scene_wall,
    single,
)
from .shapes import choice, distances, grid, log_uniform, rough, square_pixels


@family
def few_points(rng):
    """Few contact points and a load near a change of sides."""
    n = choice(rng, ((32, 32), (48, 48), (64, 64), (37, 37), (32, 128), (80, 80)))
    z = rough(rng, n) if rng.random() < 0.7 else rng.standard_normal(n)
    return at_a_change_of_sides(rng, z, log_uniform(rng, 3, 60) / z.size / 2)


@family
def few_points_smooth(rng):
    n = choice(rng, ((48, 48), (64, 64), (100, 100)))
    z = rough(rng, n, modes=(1, n[0] / rng.uniform(6, 16)))
    return at_a_change_of_sides(rng, z, log_uniform(rng, 5, 100) / z.size / 3)


@family
def few_asperities(rng):
    """Some smooth bumps of different heights, and a load near a change of sides."""
    n = choice(rng, ((64, 64), (100, 100), (81, 81), (128, 64)))
    sizes = square_pixels(n)
    z = np.zeros(n)
    for dx, dy in distances(rng, n, sizes, int(rng.integers(2, 20))):
        width = log_uniform(rng, 0.03, 0.2)
        z = np.maximum(z, rng.uniform(0.5, 1) * np.exp(-(dx**2 + dy**2) / (2 * width**2)))
    return at_a_change_of_sides(rng, z, log_uniform(rng, 5, 200) / z.size / 2)


@family
def few_alike_tops(rng):
    """Some nearly equal points far above all others, and a load near that at which the next one
    touches."""
    n = choice(rng, ((32, 32), (48, 48), (32, 64)))
    z = rough(rng, n) if rng.random() < 0.5 else rng.standard_normal(n)
    places = tuple(rng.integers(0, k, 4) for k in n)
    spread = log_uniform(rng, 1e-6, 0.1)
    z[places] = z.max() + 1 - spread * np.ptp(z) * rng.random(4)
    sizes = square_pixels(n)
    touching = load_of_area(z, (int(rng.integers(2, 5)) - 0.5) / z.size, sizes, steps=50)
    off = choice(rng, (-1, 1)) * log_uniform(rng, 1e-9, 0.1)
    return Wall(z, sizes, (touching * (1 + off),))


@family
def light(rng):
    return single(rng, rough(rng, grid(rng)), low=1e-5, high=3e-3)


@family
def change_of_sides(rng):
    n = choice(rng, ((64, 64), (96, 96), (72, 72)))
    z = choice(rng, (rough(rng, n), wave_heights(96, 6), lattice_heights(72, 12)))
    return at_a_change_of_sides(rng, z, log_uniform(rng, 5e-3, 0.7))


@family
def extreme_units(rng):
    wall = FAMILIES[choice(rng, ("self_affine", "sphere", "wave", "near_full"))](rng)
    heights, E_star, size = (10.0 ** rng.uniform(-45, 45) for _ in range(3))
    sizes = tuple(size * s for s in wall.physical_sizes)
    return Wall(wall.heights * heights, sizes, wall.loads, E_star, units=False)


def scene_surface(rng, lam_s_over_a=(2, 8)):
    """Return a table [surface] with 64 to 160 points along x; lam_s_over_a is its range."""
    n_x = choice(rng, (64, 72, 96, 100, 128, 160, 97))
    n_y = n_x if rng.random() < 0.7 else choice(rng, (32, 64, 128))
    L_over_lam_l = rng.uniform(1, 3)
    points_per_wave = rng.uniform(*lam_s_over_a)
    return {
        "kind": "self-affine",
        "hurst": round(rng.uniform(0, 1), 2),
        "L_over_lam_l": L_over_lam_l,
        "lam_l_over_lam_s": n_x / (L_over_lam_l * points_per_wave),
        "lam_s_over_a": points_per_wave,
        "seed": int(rng.integers(2**31)),
        "physical_sizes": [1.0, n_y / n_x],
    }


@family
def scene(rng):
    return scene_wall(scene_surface(rng), (log_uniform(rng, 1e-3, 1.5),))


@family
def few_points_scene(rng):
    wall = scene_wall(scene_surface(rng, lam_s_over_a=(4, 16)), (1.0,))
    p_star = log_uniform(rng, 5, 300) / wall.heights.size / 2
    return replace(
        wall, loads=(change_of_sides_near(rng, wall.heights, wall.physical_sizes, p_star),)
    )
