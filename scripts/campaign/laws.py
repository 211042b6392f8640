"""The family of interface laws: values between the loads of a law against solves at these loads."""

from dataclasses import replace

import numpy as np

import hpc_gfmd

from .registry import FAMILIES, family, keywords, outcome
from .shapes import choice, log_uniform

QUANTITIES = ("a_r", "gap_mean", "stiffness")
ANY = 1.0  # accuracy: only the claims count
BETWEEN = 3  # loads at which a law is tested
EXACT = {"accuracy": 1e-5, "precision": "double"}
WALLS = ("self_affine", "self_affine_smooth", "roll_off", "free_rough")


@family
def law_between_loads(rng):
    wall = FAMILIES[choice(rng, WALLS)](rng)
    low = log_uniform(rng, 1e-3, 0.05)
    loads = (low, low * log_uniform(rng, 2, 10))
    return replace(wall, loads=loads, judge=judged_laws)


def judged_laws(wall, way):
    """Yield (number of the load, columns) of each load between those of the law.

    What counts is the error that the law claims at the loads on either side: where it cannot reach
    the one that was asked for, it says so.
    """
    keys = keywords(wall)
    unit = wall.E_star * hpc_gfmd.solve(wall.heights, wall.E_star, fields=(), **keys).g_rms
    law = hpc_gfmd.interface_law(
        wall.heights,
        *(p_star * unit for p_star in wall.loads),
        error=max(10 * way["accuracy"], 1e-3),
        quantities=list(QUANTITIES),
        precision=way["precision"],
        **keys,
    )
    intervals = len(law.pressure) - 1
    for number in range(BETWEEN):
        k = min(int((number + 0.5) / BETWEEN * intervals), intervals - 1)
        load = float(np.sqrt(law.pressure[k] * law.pressure[k + 1]))
        exact = hpc_gfmd.solve(
            wall.heights, load, observables=["stiffness"], fields=(), **keys, **EXACT
        )
        true = [abs(float(law(name, load)) / exact.value(name) - 1) for name in QUANTITIES]
        claimed = [max(law.errors[name][k : k + 2]) for name in QUANTITIES]
        status = "converged" if exact.status == "converged" else "no truth"
        points = round(exact.a_r * wall.heights.size)
        yield number, outcome(exact, points, true, claimed, status=status, accuracy=ANY)
