"""Families with many loads, each of which starts from the previous one: up and down, by random and
by fine steps."""

from dataclasses import replace

import numpy as np

from . import closing_walls, formed_walls, light_loads, rough_walls
from .formed_walls import WAVES, lattice_heights, wave_heights
from .registry import FAMILIES, family, scene_wall
from .shapes import choice, log_uniform, rough, square_pixels

# Families with one load, in an order on which the walls of some sweeps depend.
MODULES = [module.__name__ for module in (rough_walls, closing_walls, formed_walls, light_loads)]
SINGLE = tuple(
    sorted(
        (name for name in FAMILIES if FAMILIES[name].__module__ in MODULES),
        key=lambda name: MODULES.index(FAMILIES[name].__module__),
    )
)


def _walk(rng, start, ratios, low=1e-4, high=3.0):
    """Return loads that change by these ratios from `start`, reflected at low and high."""
    loads = [start]
    for ratio in ratios:
        p = loads[-1] * ratio
        loads.append(p if low < p < high else loads[-1] / ratio)
    return tuple(float(p) for p in loads)


def _fine(rng, wall, start, step, count):
    ratios = np.full(count - 1, 1 + rng.choice([-1, 1]) * step)
    if rng.random() < 0.3:
        ratios[count // 2 :] = 1 / ratios[count // 2 :]  # and back
    return replace(wall, loads=_walk(rng, start, ratios))


def _up_and_down(rng, wall, count=12):
    """Return the wall with half of its loads rising and half falling, by moderate ratios."""
    ratios = np.concatenate(
        [
            1 + rng.uniform(0.01, 0.42, count // 2),
            1 / (1 + rng.uniform(0.01, 0.25, count - count // 2)),
        ]
    )
    return replace(
        wall, loads=_walk(rng, wall.loads[0], ratios if rng.random() < 0.5 else ratios[::-1])
    )


def _random(rng, wall, count=12):
    sizes = np.where(
        rng.random(count) < 0.5, rng.uniform(0.005, 0.3, count), 10.0 ** rng.uniform(-4, -1, count)
    )
    return replace(
        wall, loads=_walk(rng, wall.loads[0], np.exp(rng.choice([-1, 1], count) * sizes))
    )


def _random_or_up_and_down(rng, names):
    wall = FAMILIES[choice(rng, names)](rng)
    return _random(rng, wall) if rng.random() < 0.5 else _up_and_down(rng, wall)


@family
def sweep_up_and_down(rng):
    return _up_and_down(rng, FAMILIES[choice(rng, SINGLE)](rng))


@family
def sweep_random(rng):
    return _random(rng, FAMILIES[choice(rng, SINGLE)](rng))


@family
def sweep_rough(rng):
    return _random_or_up_and_down(
        rng, ("self_affine", "self_affine_smooth", "odd_grid", "roll_off")
    )


@family
def sweep_ordered(rng):
    return _random_or_up_and_down(
        rng, ("wave", "lattice", "replicas", "checkerboard", "lattice_noise")
    )


@family
def sweep_fine(rng):
    """60 loads in steps of about 0.1 %."""
    n = choice(rng, (64, 96, 128))
    wall = (
        FAMILIES["self_affine"](rng)
        if rng.random() < 0.3
        else replace(
            FAMILIES["self_affine"](rng), heights=rough(rng, (n, n)), physical_sizes=(1.0, 1.0)
        )
    )
    return _fine(
        rng,
        wall,
        choice(rng, (0.5, 0.5, 0.2, 0.05, 0.01)),
        choice(rng, (1e-3, 1e-3, 3e-4, 3e-3, 1e-2)),
        60,
    )


@family
def sweep_fine_ordered(rng):
    z = choice(
        rng, (wave_heights(*choice(rng, WAVES)), lattice_heights(72, 12), lattice_heights(96, 16))
    )
    wall = replace(FAMILIES["self_affine"](rng), heights=z, physical_sizes=square_pixels(z.shape))
    return _fine(rng, wall, log_uniform(rng, 5e-3, 0.4), choice(rng, (1e-3, 1e-2, 3e-2)), 60)


@family
def sweep_near_full(rng):
    wall = FAMILIES[choice(rng, ("near_full", "smooth_near_full", "near_full_closing"))](rng)
    return _random(rng, wall) if rng.random() < 0.7 else _fine(rng, wall, wall.loads[0], 1e-3, 40)


@family
def sweep_light(rng):
    return _random(rng, FAMILIES["few_points"](rng))


@family
def sweep_scene(rng):
    """Surfaces of the package, which low memory needs."""
    wall = FAMILIES["scene"](rng)
    return scene_wall(wall.surface, _random(rng, wall, 8).loads)
