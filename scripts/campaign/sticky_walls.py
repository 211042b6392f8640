"""Families of adhesive walls, and their truth: the equilibrium to which the solver converges from
the returned one with a residual of 1e-8.

There is no independent solution, because equilibria with attraction are not unique. The campaign
tests that the claimed errors are those of this equilibrium.
"""

from dataclasses import dataclass, replace

import numpy as np

from hpc_gfmd.driver.load import Load, Unfinished
from hpc_gfmd.laws import law_named, law_names

from .registry import FAMILIES, outcome, surface_of_wall, sweep_of
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


def judged_rows(wall, way):
    """Yield (number of the load, columns) with the true and the claimed errors of each load of an
    adhesive wall; precision and accuracy of the way are those of the solver."""
    attraction = law_of(wall, surface_of_wall(wall, float))
    settings = {"precision": way["precision"], "accuracy": way["accuracy"]}
    sweep = sweep_of(wall, attraction=attraction, **settings)
    exact = sweep_of(wall, attraction=attraction, precision="double", residual=EXACT_RESIDUAL)
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
    certificate = contact.certificate
    return outcome(
        contact,
        truth.contact_points,
        true,
        certificate.errors,
        status=contact.status if truth.status == "converged" else "no truth",
    )
