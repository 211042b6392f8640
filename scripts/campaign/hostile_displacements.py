"""The family of displacements that no solver would return, given to the certificate.

The displacement of a load is changed in ways that hide from sums or from residuals, by as much as
the certificate accepts at an accuracy; what it claims is compared with the exact contact.
"""

from dataclasses import replace

import numpy as np

from hpc_gfmd.certificate.certificate import certify
from hpc_gfmd.certificate.criterion import StoppingCriterion
from hpc_gfmd.driver.load import Load
from hpc_gfmd.operators.multilevel import Multilevel
from hpc_gfmd.operators.problem import Problem
from hpc_gfmd.operators.state import State

from .registry import FAMILIES, family, surface_of_wall, sweep_of
from .shapes import choice, rough
from .truth import DOUBTFUL, truths

WALLS = (
    "self_affine",
    "self_affine_smooth",
    "roll_off",
    "white_noise",
    "near_full",
    "sphere",
    "spikes",
    "pits",
    "hard_rough",
    "free_rough",
    "free_smooth",
    "free_hard",
)
SMALLEST = 1e-9  # change over the mean gap
LARGEST = 10.0
HALVINGS = 20  # of the logarithm of the change
SEED = 7  # of the changes


@family
def hostile_displacement(rng):
    wall = FAMILIES[choice(rng, WALLS)](rng)
    return replace(wall, loads=wall.loads[:1], judge=judged_displacements)


def changes(rng, closed):
    """Return changes of a gap of size 1 by name. closed: the points in contact."""
    n = closed.shape
    white = rng.random(n)
    smooth = rough(rng, n, hurst=0.8)
    points = np.zeros(n)
    points.flat[rng.integers(0, points.size, 3)] = -1
    opened = np.zeros(n)
    inside = np.flatnonzero(closed)
    opened.flat[rng.choice(inside, max(1, len(inside) // 200))] = 1
    return {
        "penetrates": -white,
        "penetrates in contact": -white * closed,
        "noise where it is open": rng.standard_normal(n) * ~closed,
        "both": np.where(closed, -white, rng.standard_normal(n)),
        "checkers": np.where(closed, -1.0, 1.0) * (np.indices(n).sum(0) % 2),
        "smooth": np.where(closed, -abs(smooth), smooth),
        "shifted": -np.ones(n),
        "few points": points,
        "opened": opened,
    }


def judged_displacements(wall, way):
    """Yield (number of the change, columns) of changes of the displacement of the first load."""
    dtype = np.dtype(np.float32 if way["precision"] == "single" else np.float64)
    contact, (truth,), hardness = truths(
        wall.heights, wall.physical_sizes, wall.loads, wall.free, wall.hardness, wall.hardness_star
    )
    if not truth.kkt < DOUBTFUL:
        return
    gap, problem, slope = _solved(wall, contact, hardness, dtype)
    if gap is None:
        return
    levels = Multilevel(problem.grid, problem.body, dtype, problem.grid.n[0])
    inside = tuple(slice(n) for n in wall.heights.shape)
    closed = (gap <= 0)[inside]
    unit = contact.g_rms / slope
    for number, change in enumerate(changes(np.random.default_rng(SEED), closed).values()):
        on_grid = np.zeros(gap.shape)
        on_grid[inside] = change
        on_grid *= max(abs(gap[inside]).mean(), np.finfo(dtype).tiny)
        certificate, pressure = _largest_accepted(problem, levels, gap, on_grid, way["accuracy"])
        if certificate is None:
            continue
        true = truth.errors(
            certificate.contact, certificate.gap_mean / unit, pressure[inside].astype(float) / unit
        )
        yield (
            number,
            {
                "contact": truth.contact,
                "kkt": truth.kkt,
                "status": "converged",
                "true": [float(x) for x in true],
                "claimed": [float(x) for x in certificate.errors],
                "iterations": 0,
                "fft_pairs": certificate.pairs,
            },
        )


def _solved(wall, contact, hardness, dtype):
    """Return the gap of the first load, solved well, its problem in a precision, and its slope.

    The gap is None if it cannot be solved.
    """
    unit = wall.E_star * contact.g_rms
    sweep = sweep_of(wall, hardness and hardness * unit, precision="double", residual=1e-10)
    solution = sweep.solve(Load("pressure", wall.loads[0] * unit))
    surface = surface_of_wall(wall, dtype)
    p0 = wall.loads[0] * contact.g_rms / surface.slope
    limit = (hardness or np.inf) * contact.g_rms / surface.slope
    problem = Problem(surface.grid, surface.h, p0, body=solution.body, hardness=limit)
    gap = solution.g.astype(float) if solution.status == "converged" else None
    return gap, problem, surface.slope


def _largest_accepted(problem, levels, gap, change, accuracy):
    """Return certificate and pressure of the largest change that the certificate accepts.

    None twice if it accepts none, not even the smallest.
    """
    certificate = pressure = None
    low = np.log(SMALLEST)
    high = np.log(LARGEST)
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        g = (gap + np.exp(middle) * change).astype(problem.dtype)
        p = np.empty_like(g)
        with np.errstate(all="ignore"):
            state = State(problem.grid, g, p, problem.p0)
            candidate = certify(problem, state, levels, np.float64, dual=True)
        if max(candidate.errors) <= StoppingCriterion(accuracy).largest_error:
            low = middle
            certificate = candidate
            touches = (g <= 0) & (p > 0)
            pressure = np.where(touches, p, 0.0)
            if problem.yields:
                pressure = np.where(g < 0, problem.hardness, np.minimum(pressure, problem.hardness))
        else:
            high = middle
    return certificate, pressure
