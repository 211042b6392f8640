"""Families with prescribed contact areas or mean gaps: rough walls, and walls on which the area
changes in steps, jumps, or nearly jumps."""

from dataclasses import replace

import numpy as np

from .defects import hexagonal_heights
from .formed_walls import WAVES, lattice_heights, wave_heights
from .registry import FAMILIES, Wall, family
from .shapes import choice, grid, log_uniform, rough, square_pixels

AREAS = 6  # of each wall


def areas_of(rng, z, low=None, high=0.97, free=(False, False)):
    """Return a wall with random areas between low and high, of at least two points."""
    low = max(low or 0.0, 2 / z.size)
    areas = tuple(log_uniform(rng, low, high) for _ in range(AREAS))
    return Wall(z, square_pixels(z.shape), (), free=free, targets=("a_r", areas))


@family
def target_area_rough(rng):
    return areas_of(rng, rough(rng, grid(rng)), low=0.003)


@family
def target_area_steep(rng):
    """Nearly full contact, where many points change sides within a small range of loads."""
    return areas_of(rng, rough(rng, grid(rng)), low=0.8, high=0.9999)


@family
def target_area_few(rng):
    return areas_of(rng, rough(rng, grid(rng)), high=0.02)


@family
def target_area_needles(rng):
    """Single points high above a rough wall, of different or nearly equal heights."""
    z = rough(rng, grid(rng))
    needles = int(rng.integers(2, 60))
    spread = choice(rng, (1, 1, 1e-3, 1e-6))
    places = tuple(rng.integers(0, n, needles) for n in z.shape)
    z[places] = z.max() + choice(rng, (1, 5, 30)) * (1 + spread * rng.random(needles))
    return areas_of(rng, z, high=0.5)


@family
def target_area_bricks(rng):
    """Blocks with constant heights and joints between them."""
    n = choice(rng, ((64, 64), (96, 96), (96, 64), (128, 128)))
    size = choice(rng, (4, 8, 16))
    joint = choice(rng, (1, 1, 2))
    spread = choice(rng, (1, 1e-2, 1e-4, 1e-7))
    blocks = spread * rng.standard_normal((n[0] // size, n[1] // size))
    z = np.repeat(np.repeat(blocks, size, axis=0), size, axis=1)
    x, y = np.ix_(np.arange(n[0]) % size, np.arange(n[1]) % size)
    z = z - log_uniform(rng, 0.1, 3) * ((x < joint) | (y < joint))
    return areas_of(rng, z + choice(rng, (0, 1e-9, 1e-4)) * rough(rng, n))


@family
def target_area_ordered(rng):
    """Areas that jump, because equal peaks touch together."""
    z = choice(
        rng,
        (
            wave_heights(*choice(rng, WAVES)),
            lattice_heights(72, 12),
            lattice_heights(96, 16),
            hexagonal_heights(rng, 72, 6, 0, 0),
        ),
    )
    return areas_of(rng, z, low=0.003)


@family
def target_area_nearly_ordered(rng):
    """Peaks that are almost exactly equal."""
    spread = choice(rng, (1e-12, 1e-9, 1e-6, 1e-4))
    z = choice(rng, (lattice_heights(72, 12), hexagonal_heights(rng, 64, 4, 0, 0)))
    return areas_of(rng, z + spread * np.ptp(z) * rng.standard_normal(z.shape), low=0.003)


@family
def target_area_tall_point(rng):
    wall = FAMILIES["tall_point"](rng)
    return areas_of(rng, wall.heights, high=0.1)


@family
def target_area_line(rng):
    """Walls that vary along one axis."""
    n = choice(rng, ((1, 128), (1, 500), (1, 96)))
    return areas_of(rng, np.repeat(rough(rng, n, modes=(1, n[1] / 6)), 24, axis=0), low=0.02)


@family
def target_area_texture(rng):
    """A plateau of fine texture beside grooves, at the limit of single precision."""
    n = choice(rng, (64, 96))
    z = log_uniform(rng, 1e-6, 1e-3) * rough(rng, (n, n))
    z[:: choice(rng, (8, 16))] -= 1
    return areas_of(rng, z, low=0.005, high=0.8)


@family
def target_area_any(rng):
    """A wall of any family with single loads."""
    names = [
        name
        for name in FAMILIES
        if name.partition("_")[0] not in ("target", "sweep", "hard", "plastic", "history")
    ]
    wall = FAMILIES[choice(rng, [name for name in names if name != "long_strip"])](rng)
    with_areas = areas_of(rng, np.asarray(wall.heights, float))
    return replace(with_areas, physical_sizes=wall.physical_sizes, free=wall.free)


@family
def target_gap(rng):
    z = rough(rng, grid(rng))
    gaps = tuple(log_uniform(rng, 1e-3, 0.8) * (z.max() - z.mean()) / z.std() for _ in range(4))
    free = choice(rng, ((False, False), (False, False), (True, True)))
    return Wall(z, square_pixels(z.shape), (), free=free, targets=("gap_over_h_rms", gaps))
