"""Loads near the limit of what a flat top can carry, and contacts in which all points yield."""

import numpy as np
import pytest
from oracle import solve_yielding

import hpc_gfmd

RIDGE = 1.0 * (np.abs(np.arange(16) - 8) < 4)[:, None] * np.ones(16)
PINS = np.zeros((16, 16))
PINS[np.ix_(np.arange(16) % 8 < 2, np.arange(16) % 8 < 2)] = 1.0


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


@pytest.mark.parametrize("hardness", [1e-5, 1e-3, 1e-1])
@pytest.mark.parametrize("times", [0.5, 1.05, 4.0])
def test_pins_that_all_yield(hardness, times):
    """If the pins cannot carry the load, the body also touches the plate, however soft it is."""
    load = times * hardness * PINS.mean()
    solution = solve(PINS, load, hardness, 1e-3)
    assert solution.status == "converged"
    assert solution.pressure.mean() == pytest.approx(load, rel=2e-3)
    assert solution.pressure.max() <= hardness
    assert solution.a_r >= load / hardness * (1 - 1e-9)
    exact = solve_yielding(PINS, load, hardness)
    assert solution.a_r == pytest.approx(exact.a_r, rel=solution.errors[0] + 1e-9)


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
