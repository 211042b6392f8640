"""Families of adhesive walls, and their truth: the equilibrium to which the solver converges from
the returned one with a residual of 1e-8.

There is no independent solution, because equilibria with attraction are not unique. The campaign
tests that the claimed errors are those of this equilibrium.
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

EXACT_RESIDUAL = 1e-8  # of the truth
WEAKEST = 0.01  # range of kappa
STRONGEST = 3.0
SHORTEST = 0.02  # range of reach
LONGEST = 0.2


@dataclass(frozen=True)
class Attraction:
    """An attraction relative to the roughness of a wall.

    The mean wave has the length 2 pi times the rms slope over the rms curvature.

    Attributes
    ----------
    kappa : float
        Curvature of the law over the stiffness of the mean wave.
    reach : float
        Range over the rms slope times the mean wave.
    law : str
        Name of the law.
    """

    kappa: float
    reach: float
    law: str


def _sticky(kind):
    def make_wall(rng):
        kappa = log_uniform(rng, WEAKEST, STRONGEST)
        reach = log_uniform(rng, SHORTEST, LONGEST)
        attraction = Attraction(kappa, reach, str(rng.choice(law_names())))
        return replace(FAMILIES[kind](rng), attraction=attraction, judge=judged_rows)

    return make_wall


for _name, _kind in {
    "sticky_rough": "self_affine",
    "sticky_smooth": "self_affine_smooth",
    "sticky_roll_off": "roll_off",
    "free_sticky": "free_rough",
}.items():
    FAMILIES[_name] = _sticky(_kind)


def law_of(wall, surface):
    """Return the law of a wall in its units; surface is the wall as solvers take it."""
    z = wall.heights
    a = surface.grid.a
    curvatures = [np.diff(z, 2, axis).std() / a**2 for axis in (0, 1) if z.shape[axis] > 2]
    wave = 2 * np.pi * surface.g_rms / max(max(curvatures), surface.g_rms * np.pi / a / 8)
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
    """Yield (number of the load, columns) with the true and the claimed errors of each load.

    Parameters
    ----------
    wall : Wall
        With an attraction.
    precision : str
        Of the solver.
    accuracy : float
        Requested accuracy.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        sweep = sweep_of(wall, precision=precision, accuracy=accuracy)
        exact = sweep_of(wall, precision="double", residual=EXACT_RESIDUAL)
        unit = wall.E_star * sweep.surface.g_rms
        for k, p_star in enumerate(wall.loads):
            load = Load("pressure", float(p_star * unit))
            contact = sweep.solve(load)
            pressure = contact.field("pressure")[:].astype(float)
            start = Unfinished(contact.g.astype(float), load.value, 0, 0.0)
            truth = exact.solve(load, unfinished=start)
            yield k, _judged(contact, pressure, truth)


def _judged(contact, pressure, truth):
    exact_pressure = truth.field("pressure")[:].astype(float)
    true = (
        abs(contact.contact_points - truth.contact_points) / max(truth.contact_points, 1),
        abs(contact.gap_mean - truth.gap_mean) / truth.gap_mean if truth.gap_mean else 0.0,
        np.linalg.norm(pressure - exact_pressure) / np.linalg.norm(exact_pressure),
    )
    return {
        "contact": truth.contact_points,
        "kkt": 0.0,  # the status of the truth counts instead
        "status": contact.status if truth.status == "converged" else "no truth",
        "true": [float(x) for x in true],
        "claimed": [float(x) for x in contact.certificate.errors],
        "stability": contact.certificate.stability,
        "iterations": contact.iterations,
        "fft_pairs": round(contact.fft_pairs, 2),
    }
