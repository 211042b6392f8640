"""Loads next to what a flat top carries at most, and contacts all of whose points yield."""

import numpy as np
import pytest
from oracle import solve_yielding

import hpc_gfmd

RIDGE = 1.0 * (np.abs(np.arange(16) - 8) < 4)[:, None] * np.ones(16)
PINS = np.zeros((16, 16))
PINS[np.ix_(np.arange(16) % 8 < 2, np.arange(16) % 8 < 2)] = 1.0


def solved(heights, load, hardness, accuracy):
    return hpc_gfmd.solve(
        heights, load, hardness=hardness, accuracy=accuracy, fields=("pressure", "gap")
    )


@pytest.mark.parametrize("excess", [-1e-2, -1e-4, 1e-5, 1e-4, 1e-2])
@pytest.mark.parametrize("accuracy", [1e-1, 1e-3])
@pytest.mark.parametrize("hardness", [0.1, 1.0])
def test_a_ridge_next_to_its_limit(hardness, excess, accuracy):
    """What the ridge cannot carry the plane below it has to: the gap falls to a hundredth."""
    load = hardness * RIDGE.mean() * (1 + excess)
    exact = solve_yielding(RIDGE, load, hardness)
    found = solved(RIDGE, load, hardness, accuracy)
    assert found.status == "converged"
    assert abs(found.a_r / exact.a_r - 1) <= found.errors[0] <= accuracy
    assert abs(found.gap_mean / exact.gap_mean - 1) <= found.errors[1] <= accuracy
    assert (exact.a_r > RIDGE.mean()) == (excess > 0)


@pytest.mark.parametrize("hardness", [1e-5, 1e-3, 1e-1])
@pytest.mark.parametrize("times", [0.5, 1.05, 4.0])
def test_pins_that_all_yield(hardness, times):
    """The body comes down onto the plate where the pins carry too little, however soft it is."""
    load = times * hardness * PINS.mean()
    found = solved(PINS, load, hardness, 1e-3)
    assert found.status == "converged"
    assert found.pressure.mean() == pytest.approx(load, rel=2e-3)
    assert found.pressure.max() <= hardness
    assert found.a_r >= load / hardness * (1 - 1e-9)
    exact = solve_yielding(PINS, load, hardness)
    assert found.a_r == pytest.approx(exact.a_r, rel=found.errors[0] + 1e-9)


def test_a_load_that_whole_points_carry_at_the_hardness():
    """Half of the points at the hardness carry all: which gap of an interval is right is open, and
    the error says so."""
    heights = np.random.default_rng(1).standard_normal((32, 32))
    found = solved(heights, 0.5e-4, 1e-4, 1e-2)
    assert found.status == "converged"
    assert found.a_r == pytest.approx(0.5, abs=2 / heights.size)
    ordered = np.sort(heights.ravel())[::-1]
    level = ordered[heights.size // 2]
    rigid = np.maximum(level - heights, 0).mean()
    assert found.gap_mean == pytest.approx(rigid, rel=2e-2)
