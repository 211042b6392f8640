"""What a family is: a function that makes a random wall and its loads. Walls are in units of
nothing."""

import zlib
from dataclasses import dataclass, replace

import numpy as np

import hpc_gfmd

from .shapes import log_uniform, square_pixels
from .truth import Contact

FAMILIES = {}


@dataclass(frozen=True)
class Wall:
    """heights (peaks up); physical_sizes; loads: p* in the order of solving; E_star; surface: table
    [surface] of a scene that has these heights, where one does; units: whether the campaign may
    choose others; free: whether the wall ends along x, along y; hardness: over the largest pressure
    of the loads without one; hardness_star: or over E* g_rms; targets: what is asked for in place
    of `loads`, a quantity (a_r, or gap_over_h_rms) and its values, for each of which a load of its
    own is searched for; attraction: a sticky_walls.Attraction.
    """

    heights: np.ndarray
    physical_sizes: tuple[float, float]
    loads: tuple[float, ...]
    E_star: float = 1.0
    surface: dict | None = None
    units: bool = True
    free: tuple[bool, bool] = (False, False)
    hardness: float | None = None
    hardness_star: float | None = None
    attraction: object = None
    targets: tuple[str, tuple[float, ...]] | None = None


def family(function):
    FAMILIES[function.__name__] = function
    return function


def make(name, seed, index):
    """Make wall number `index` of a family."""
    rng = np.random.default_rng([seed, index, zlib.crc32(name.encode())])
    wall = FAMILIES[name](rng)
    if wall.units and rng.random() < 0.5:
        heights, size, E_star = (log_uniform(rng, 1e-3, 1e3) for _ in range(3))
        wall = replace(
            wall,
            heights=wall.heights * heights,
            physical_sizes=tuple(size * s for s in wall.physical_sizes),
            E_star=E_star,
        )
    return wall


def single(rng, z, sizes=None, low=1e-3, high=1.0, **others):
    """Make a wall with one load, log-uniform between low and high."""
    return Wall(z, tuple(sizes or square_pixels(z.shape)), (log_uniform(rng, low, high),), **others)


def load_of_area(z, a_r, sizes=None, steps=18):
    """Return the p* at which about a share a_r of the points touches, by bisection."""
    contact = Contact(z, sizes or square_pixels(z.shape))
    low, high = 1e-7, 50.0
    for _ in range(steps):
        middle = np.sqrt(low * high)
        if contact.solve(middle).contact < a_r * z.size:
            low = middle
        else:
            high = middle
    return float(np.sqrt(low * high))


def change_of_sides_near(rng, z, sizes, p_star):
    """Find a load near p* at which the number of points changes, off by a random small share."""
    contact = Contact(z, sizes)
    low, high = p_star, p_star * 1.2
    n_low, n_high = contact.solve(low).contact, contact.solve(high).contact
    if n_low == n_high:
        return p_star
    for _ in range(int(rng.integers(8, 22))):
        middle = 0.5 * (low + high)
        n = contact.solve(middle).contact
        low, high = (middle, high) if abs(n - n_low) < abs(n - n_high) else (low, middle)
    return float(rng.choice([low, high]))


def scene_wall(surface, loads):
    """Make a Wall with the heights that the program makes of a table [surface]."""
    made = hpc_gfmd.make_surface(**surface)
    return Wall(made.heights, made.sizes, tuple(loads), 1.0, surface, units=False, free=made.free)
