"""Families of walls whose surfaces attract each other, and their truth: the equilibrium that is
reached by going on from the one that was returned, to a residual of 1e-8.

There is no independent solution: an equilibrium with attraction is not the only one. What is tested
is that the errors that are claimed are those of this equilibrium.
"""

import warnings
from dataclasses import dataclass, replace

import numpy as np

from hpc_gfmd.driver.load import Load, Unfinished
from hpc_gfmd.driver.sweep import make_sweep
from hpc_gfmd.laws import law_named, law_names
from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.scene import SolverTable
from hpc_gfmd.surface.build import surface_of
from hpc_gfmd.surface.topography import Topography

from .registry import FAMILIES
from .shapes import log_uniform

GOING_ON = 1e-8  # residual
WEAKEST, STRONGEST = 0.01, 3.0  # kappa, by the slope and the curvature of the wall
SHORTEST, LONGEST = 0.02, 0.2  # range over the height that a point rises above its neighbours


@dataclass(frozen=True)
class Attraction:
    """kappa: curvature of the law over the stiffness of waves as long as the mean one, pi/a times
    slope over curvature; reach: range over slope times that wave; law: its name."""

    kappa: float
    reach: float
    law: str


def _sticky(kind):
    def make_wall(rng):
        kappa = log_uniform(rng, WEAKEST, STRONGEST)
        reach = log_uniform(rng, SHORTEST, LONGEST)
        attraction = Attraction(kappa, reach, str(rng.choice(law_names())))
        return replace(FAMILIES[kind](rng), attraction=attraction)

    return make_wall


for _name, _kind in {
    "sticky_rough": "self_affine",
    "sticky_smooth": "self_affine_smooth",
    "sticky_roll_off": "roll_off",
    "free_sticky": "free_rough",
}.items():
    FAMILIES[_name] = _sticky(_kind)


def law_of(wall, surface):
    """Return the law of a wall in its units."""
    z, a = wall.heights, surface.grid.a
    bends = [np.diff(z, 2, axis).std() / a**2 for axis in (0, 1) if z.shape[axis] > 2]
    wave = 2 * np.pi * surface.g_rms / max(max(bends), surface.g_rms * np.pi / a / 8)
    reach = wall.attraction.reach * surface.g_rms * wave
    work = wall.attraction.kappa * reach**2 * wall.E_star * np.pi / wave
    return law_named(wall.attraction.law, work, reach)


def sweep_of(wall, **settings):
    """Return a sweep of a wall on this process."""

    def make_surface(dtype):
        topography = Topography(
            wall.heights.shape,
            wall.physical_sizes,
            lambda i, j: np.asarray(wall.heights[i:j], float),
        )
        return surface_of(topography, SerialComm(), dtype, 1, wall.free)

    return make_sweep(
        make_surface,
        SolverTable(**settings),
        wall.E_star,
        body=body_of_free(wall.free),
        attraction=law_of(wall, make_surface(np.dtype(float))),
    )


def body_of_free(free):
    """Return the half-space with these edges."""
    from hpc_gfmd.bodies import body_of
    from hpc_gfmd.scene import Material

    return body_of(Material(), free)


def judged_rows(wall, precision, accuracy):
    """Yield (load, numbers): the true and the claimed errors of (area, mean gap, pressure) of each
    load of a wall."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        sweep = sweep_of(wall, precision=precision, accuracy=accuracy)
        exact = sweep_of(wall, precision="double", residual=GOING_ON)
        unit = wall.E_star * sweep.surface.g_rms
        for k, p_star in enumerate(wall.loads):
            load = Load("pressure", float(p_star * unit))
            found = sweep.solve(load)
            pressure = found.field("pressure")[:].astype(float)
            start = Unfinished(found.g.astype(float), load.value, 0, 0.0)
            truth = exact.solve(load, unfinished=start)
            yield k, _judged(found, pressure, truth)


def _judged(found, pressure, truth):
    right = truth.field("pressure")[:].astype(float)
    true = (
        abs(found.contact_points - truth.contact_points) / max(truth.contact_points, 1),
        abs(found.gap_mean - truth.gap_mean) / truth.gap_mean if truth.gap_mean else 0.0,
        np.linalg.norm(pressure - right) / np.linalg.norm(right),
    )
    return {
        "contact": truth.contact_points,
        "kkt": 0.0,  # whether the truth is one its status says
        "status": found.status if truth.status == "converged" else "no truth",
        "true": [float(x) for x in true],
        "claimed": [float(x) for x in found.certificate.errors],
        "stability": found.certificate.stability,
        "iterations": found.iterations,
        "fft_pairs": round(found.fft_pairs, 2),
    }
