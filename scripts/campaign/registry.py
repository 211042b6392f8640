"""The registry of families: functions that make random walls and their loads, without units."""

import zlib
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

import hpc_gfmd
from hpc_gfmd.bodies import body_of
from hpc_gfmd.driver.contact_model import ContactModel
from hpc_gfmd.driver.sweep import Sweep
from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.scene import Material, SolverTable
from hpc_gfmd.surface.build import surface_of
from hpc_gfmd.surface.topography import Topography

from .shapes import log_uniform, square_pixels
from .truth import Contact

FAMILIES = {}


@dataclass(frozen=True)
class Wall:
    """A wall and its loads.

    Attributes
    ----------
    heights : ndarray, shape (n_x, n_y)
        Peaks up.
    physical_sizes : (float, float)
        Size of the cell.
    loads : tuple of float
        p* in the order of solving.
    E_star : float
        Modulus.
    surface : dict or None
        Table [surface] of a scene with these heights, if there is one.
    units : bool
        Whether the campaign may change the units.
    free : (bool, bool)
        Whether x and y have free edges.
    hardness : float or None
        Hardness over the largest pressure of the loads without one.
    hardness_star : float or None
        Hardness over E* g_rms.
    attraction : sticky_walls.Attraction or None
        Attraction of the surfaces.
    targets : (str, tuple of float) or None
        Quantity (a_r or gap_over_h_rms) and its values, which are prescribed instead of loads.
    judge : callable or None
        How such walls are judged, if not by the truth of their loads: judge(wall, way) yields
        (number, columns); way holds the solver, the precision and the accuracy.
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
    judge: object = None


def family(function):
    """Register a family (decorator)."""
    FAMILIES[function.__name__] = function
    return function


def make(name, seed, index):
    """Return wall number `index` of a family, in random units unless the family fixes them."""
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


def single(rng, z, sizes=None, low=1e-3, high=1.0, **fields):
    """Return a wall with one load, log-uniform between low and high.

    **fields are further fields of Wall.
    """
    return Wall(z, tuple(sizes or square_pixels(z.shape)), (log_uniform(rng, low, high),), **fields)


def load_of_area(z, a_r, sizes=None, steps=18):
    """Return the p* at which about a share a_r of the points touches, by bisection."""
    contact = Contact(z, sizes or square_pixels(z.shape))
    low = 1e-7
    high = 50.0
    for _ in range(steps):
        middle = np.sqrt(low * high)
        if contact.solve(middle).contact < a_r * z.size:
            low = middle
        else:
            high = middle
    return float(np.sqrt(low * high))


def nearly_closed(rng, z, low, high):
    """Return a wall at a load below that of full contact by a share between low and high."""
    sizes = square_pixels(z.shape)
    contact = Contact(z, sizes)
    closing = contact.times(contact.K, contact.h).max()
    return Wall(z, sizes, (closing * (1 - log_uniform(rng, low, high)),))


def at_a_change_of_sides(rng, z, p_star):
    """Return a wall at the load of `change_of_sides_near`."""
    sizes = square_pixels(z.shape)
    return Wall(z, sizes, (change_of_sides_near(rng, z, sizes, p_star),))


def change_of_sides_near(rng, z, sizes, p_star):
    """Return a load near p* at which the number of contact points changes, off by a small share."""
    contact = Contact(z, sizes)
    low = p_star
    high = p_star * 1.2
    n_low = contact.solve(low).contact
    n_high = contact.solve(high).contact
    if n_low == n_high:
        return p_star
    for _ in range(int(rng.integers(8, 22))):
        middle = 0.5 * (low + high)
        n = contact.solve(middle).contact
        if abs(n - n_low) < abs(n - n_high):
            low = middle
        else:
            high = middle
    return float(rng.choice([low, high]))


def with_random_steps(rng, wall, low, high):
    """Return the wall with eight loads, each above or below the one before by e^low to e^high."""
    steps = np.exp(rng.choice([-1, 1], 7) * rng.uniform(low, high, 7))
    return replace(wall, loads=tuple(wall.loads[0] * np.cumprod([1.0, *steps])))


def scene_wall(surface, loads):
    """Return a wall with the heights that the package makes from a table [surface]."""
    wall = hpc_gfmd.make_surface(**surface)
    return Wall(wall.heights, wall.sizes, tuple(loads), 1.0, surface, units=False, free=wall.free)


def keywords(wall):
    """Return the keywords of hpc_gfmd.solve that describe a wall."""
    return {
        "E_star": wall.E_star,
        "physical_sizes": wall.physical_sizes,
        "boundary": ["free" if ends else "periodic" for ends in wall.free],
    }


def outcome(solution, contact, true, claimed=None, **columns):
    """Return the columns of a solution with its exact number of contact points and its true errors
    of area, mean gap and pressure.

    The claimed errors are those of the solution by default. `kkt` is the violation of its
    conditions by the truth; 0 where there is no other truth than the status says.
    """
    return {
        "contact": contact,
        "kkt": 0.0,
        "status": solution.status,
        "true": [float(x) for x in true],
        "claimed": [float(x) for x in claimed or solution.errors],
        "iterations": solution.iterations,
        "fft_pairs": round(solution.fft_pairs, 2),
    } | columns


def compared(solution, truth, contact, modulus):
    """Return the columns of a solution with its exact contact.

    modulus: E*, in the units of the solution.
    """
    true = contact.errors_of(solution, truth, modulus)
    return outcome(solution, truth.contact, true, kkt=truth.kkt)


def sweep_of(wall, hardness=None, attraction=None, **settings):
    """Return a sweep of a wall on this process, with a hardness and an attraction in the units of
    the wall. **settings are keys of [solver] in a scene."""
    model = ContactModel(wall.E_star, body_of(Material(), wall.free), hardness, attraction)
    return Sweep(partial(surface_of_wall, wall), SolverTable(**settings), model)


def surface_of_wall(wall, dtype):
    """Return the surface of a wall as solvers take it, on this process."""
    topography = Topography(
        wall.heights.shape, wall.physical_sizes, lambda i, j: np.asarray(wall.heights[i:j], float)
    )
    return surface_of(topography, SerialComm(), np.dtype(dtype), 1, wall.free)
