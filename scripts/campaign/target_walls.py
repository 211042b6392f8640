"""Families with prescribed contact areas or mean gaps: rough walls, and walls on which the area
changes in steps, jumps, or nearly jumps. By how much a target is missed counts as an error, too."""

from dataclasses import replace
from math import prod

import numpy as np

import hpc_gfmd

from .defects import hexagonal_heights
from .formed_walls import WAVES, lattice_heights, wave_heights
from .registry import FAMILIES, Wall, compared, family, keywords
from .shapes import choice, grid, log_uniform, rough, square_pixels
from .truth import Contact

AREAS = 6  # of each wall
EQUAL_LOADS = 1e-12  # relative difference of loads that count as equal
ROUNDED = 1e-9  # relative rounding errors of a target


def with_targets(z, quantity, values, **fields):
    """Return a wall with prescribed values of a quantity; **fields are further ones of Wall."""
    targets = quantity, tuple(values)
    return Wall(z, square_pixels(z.shape), (), targets=targets, judge=judged_targets, **fields)


def judged_targets(wall, way):
    """Yield (number of the target, columns) of each prescribed area or gap."""
    contact = Contact(wall.heights, wall.physical_sizes, wall.free)
    unit = wall.E_star * contact.g_rms
    hardness = wall.hardness_star
    quantity, values = wall.targets
    start = None
    for number, value in enumerate(values):
        solution = hpc_gfmd.solve(
            wall.heights,
            hardness=hardness and hardness * unit,
            precision=way["precision"],
            accuracy=way["accuracy"],
            fields=["pressure"],
            **keywords(wall),
            **{quantity: value},
        )
        p_star = solution.p / wall.E_star / contact.g_rms
        truth = contact.solve(p_star, start, hardness)
        start = truth.pressure
        columns = {"p_star": p_star} | compared(solution, truth, contact, wall.E_star)
        columns["jump"] = "jumps" in (solution.note or "")  # whether one was noted
        if solution.status == "converged" and quantity == "a_r":
            columns["true"][0] += missed_area(
                wall.heights, solution, truth, contact, value, way, hardness
            )
        elif solution.status == "converged":
            gap = truth.gap_mean / np.std(contact.h[contact.D])
            columns["true"][1] += missed_share(gap, value, way["accuracy"])
        yield number, columns


def missed_share(reached, value, accuracy):
    """Return by which share of a value it is missed, 0 within the accuracy."""
    share = abs(reached / value - 1)
    return float(share) if share > accuracy + ROUNDED else 0.0


def missed_area(z, solution, truth, contact, a_r, way, hardness):
    """Return by which share a prescribed area of a wall z is missed; truth is that of its load.

    It is 0 within the accuracy, within one point (of a wall that varies along one axis one line),
    or within the accuracy of the nearer side of a noted jump that the truth has, too.
    """
    points = a_r * contact.N
    distance = abs(round(solution.a_r * contact.N) - points)
    alike = [n for axis, n in enumerate(z.shape) if not np.ptp(z, axis=axis).any()]
    if distance <= max(way["accuracy"] * points, prod(alike)) + ROUNDED * points:
        return 0.0
    if "jumps" in (solution.note or ""):
        nearest = nearest_count(contact, solution.p_star, points, hardness)
        around = max(way["accuracy"] * nearest, 1)
        if distance <= abs(nearest - points) + around + truth.ties_in + truth.ties_out:
            return 0.0
    return distance / points


def nearest_count(contact, p_star, points, hardness=None):
    """Return the number of contact points nearest to a target that loads near p* have, by
    bisection. Contacts with ties are on both sides of a jump and do not count."""
    counts = {}
    nearest = np.inf

    def count(p):
        nonlocal nearest
        if p not in counts:
            truth = contact.solve(p, hardness=hardness)
            counts[p] = truth.contact
            ties = truth.ties_in + truth.ties_out
            if ties == 0 and abs(truth.contact - points) < abs(nearest - points):
                nearest = truth.contact
        return counts[p]

    low = p_star
    step = 1e-6
    while count(low) >= points and step < 1:
        low = low / (1 + step)
        step = 4 * step
    high = p_star
    step = 1e-6
    while count(high) < points and step < 1:
        high = high * (1 + step)
        step = 4 * step
    while high / low - 1 > EQUAL_LOADS and abs(nearest - points) > 1:
        middle = np.sqrt(low * high)
        if count(middle) < points:
            low = middle
        else:
            high = middle
    return nearest


def areas_of(rng, z, low=None, high=0.97, free=(False, False)):
    """Return a wall with random areas between low and high, of at least two points."""
    low = max(low or 0.0, 2 / z.size)
    areas = tuple(log_uniform(rng, low, high) for _ in range(AREAS))
    return with_targets(z, "a_r", areas, free=free)


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
    return with_targets(z, "gap_over_h_rms", gaps, free=free)
