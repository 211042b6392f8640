"""Loads near the limit of what a flat top can carry, or whole points at the hardness."""

import numpy as np
import pytest
from campaign import families
from campaign.truth import truths
from oracle import solve_yielding

import hpc_gfmd

RIDGE = 1.0 * (np.abs(np.arange(16) - 8) < 4)[:, None] * np.ones(16)


def solve(heights, load, hardness, accuracy):
    return hpc_gfmd.solve(
        heights, load, hardness=hardness, accuracy=accuracy, fields=("pressure", "gap")
    )


@pytest.mark.parametrize("excess", [-1e-2, -1e-4, 1e-5, 1e-4, 1e-2])
@pytest.mark.parametrize("accuracy", [1e-1, 1e-3])
@pytest.mark.parametrize("hardness", [0.1, 1.0])
def test_a_ridge_next_to_its_limit(hardness, excess, accuracy):
    """Beyond the limit of the ridge the plane below it carries the rest, and the gap collapses."""
    load = hardness * RIDGE.mean() * (1 + excess)
    exact = solve_yielding(RIDGE, load, hardness)
    solution = solve(RIDGE, load, hardness, accuracy)
    assert solution.status == "converged"
    assert abs(solution.a_r / exact.a_r - 1) <= solution.errors[0] <= accuracy
    assert abs(solution.gap_mean / exact.gap_mean - 1) <= solution.errors[1] <= accuracy
    assert (exact.a_r > RIDGE.mean()) == (excess > 0)


def test_a_load_that_whole_points_carry_at_the_hardness():
    """Half of the points at the hardness carry the whole load.

    The gap is then not unique within an interval, and its estimated error reflects that.
    """
    heights = np.random.default_rng(1).standard_normal((32, 32))
    solution = solve(heights, 0.5e-4, 1e-4, 1e-2)
    assert solution.status == "converged"
    assert solution.a_r == pytest.approx(0.5, abs=2 / heights.size)
    ordered = np.sort(heights.ravel())[::-1]
    level = ordered[heights.size // 2]
    rigid = np.maximum(level - heights, 0).mean()
    assert solution.gap_mean == pytest.approx(rigid, rel=2e-2)


def test_few_elastic_points_that_carry_the_rest_of_the_load():
    """Plates of which one yields but for two points; a second load, .02 % larger, takes six."""
    wall = families.make("plastic_steps", 71203, 2)
    contact, exact, hardness = truths(
        wall.heights, wall.physical_sizes, wall.loads[:2], hardness_star=wall.hardness_star
    )
    unit = wall.E_star * contact.g_rms
    loads = np.array(wall.loads[:2]) * unit
    solutions = hpc_gfmd.solve(
        wall.heights, loads, wall.E_star, wall.physical_sizes, 1e-2, hardness=hardness * unit
    )
    for solution, truth in zip(solutions, exact, strict=True):
        points = solution.a_r * wall.heights.size
        assert abs(points / truth.contact - 1) <= solution.errors[0] <= 1e-2
    assert exact[1].contact > exact[0].contact
