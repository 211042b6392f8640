"""Branches of contacts with adhesion: which load follows which, and how a saddle is left."""

from dataclasses import replace

import numpy as np
import oracle
import pytest
from contacts import random_heights

from hpc_gfmd.driver.branches import KICK_LENGTHS, SaddleGuard, goes_on
from hpc_gfmd.driver.load import Load
from hpc_gfmd.laws import law_named
from hpc_gfmd.operators.problem import Problem
from hpc_gfmd.parallel.grid import Grid
from hpc_gfmd.solvers.bpx import Bpx

N = 24


def halves(rows):
    return [(0, rows // 2), (rows // 2, rows)]


FOLLOWS = [
    ("approach", 0.2, 0.1, True),
    ("approach", 0.1, 0.1, True),
    ("approach", 0.1, 0.2, False),
    ("approach", 0.1, 0.0, False),
    ("retraction", 0.1, 0.2, True),
    ("retraction", 0.1, 0.1, True),
    ("retraction", 0.2, 0.1, False),
]


def test_loads_that_follow_each_other():
    """On approach loads rise, and nothing follows a load without contact; on retraction they
    fall."""
    for branch, p0, p0_before, follows in FOLLOWS:
        assert goes_on(branch, p0, p0_before) == follows


def test_loads_that_hold_the_bodies_further_apart():
    """Nothing is solved where the bodies have come apart, also not at the same gap again."""
    for quantity, beyond, before in [("gap_mean", 1.1, 0.9), ("approach", -0.1, 0.1)]:
        separated = Load(quantity, (beyond + before) / 2)
        assert separated.is_beyond(separated)
        assert Load(quantity, beyond).is_beyond(separated)
        assert not Load(quantity, before).is_beyond(separated)


def energy(solver, g):
    """The energy of a gap by a dense matrix, over that of the spring as it is; where points overlap
    they attract each other as in contact."""
    problem = solver.problem
    u = (g - problem.heights).ravel()
    K = oracle.stiffness(solver.grid.n, (N, N))
    of_spring = 0.5 * problem.spring * N**2 * (g - solver.state.g).mean() ** 2
    of_attraction = problem.attraction.energy(np.maximum(g, 0)).sum()
    return 0.5 * u @ K @ u + solver.state.p0 * u.sum() + of_spring + of_attraction


@pytest.mark.parametrize("branch", ["approach", "retraction"])
def test_a_kick_lowers_the_energy(branch, monkeypatch):
    """By as much as a dense matrix says, and more than other kicks along the same mode do. The rows
    come in two pieces. The force of a spring follows the gap."""
    monkeypatch.setattr(
        Grid, "pieces", lambda grid, rows=None: halves(grid.shape[0] if rows is None else rows)
    )
    x = 2 * np.pi * np.arange(N) / N
    heights = 2 - np.cos(x)[:, None] - np.cos(2 * x + 0.3)
    law = law_named("exponential", 0.05, 0.4)
    solver = Bpx(Problem(Grid((N, N), (1.0, 1.0)), heights, 0.05, attraction=law, spring=0.01))
    solver.start(heights - heights.min() + 0.05)
    guard = SaddleGuard(solver, branch)
    guard.look()
    mode = guard._mode
    g = solver.state.g.copy()
    p0 = solver.state.p0
    length = guard._length_of_kick(mode)
    work, largest = guard._work_along(mode)
    assert largest == np.abs(mode).max()
    change = length * work + length**2 / 2 + guard._gain_along(mode, length)
    assert change < 0
    assert change == pytest.approx(energy(solver, g + length * mode) - energy(solver, g), rel=1e-6)
    for share in KICK_LENGTHS:
        other = np.copysign(share * 0.4 / largest, length)
        assert energy(solver, g + other * mode) >= energy(solver, g + length * mode) - 1e-12
    solver.state.stability = replace(solver.state.stability, value=-1.0)
    assert guard.leave_saddle()
    assert guard.kicks == 1
    assert solver.state.g == pytest.approx(np.maximum(g + length * mode, 0), abs=1e-12)
    moved = solver.state.g.mean() - g.mean()
    assert solver.state.p0 == pytest.approx(p0 + 0.01 * moved, abs=1e-12)
    assert abs(moved) > 1e-4


@pytest.mark.parametrize(("branch", "side"), [("approach", -1), ("retraction", 1)])
def test_where_both_sides_lower_the_energy_the_branch_decides(branch, side, monkeypatch):
    """Retraction opens the contact, approach closes it."""
    heights = random_heights((8, 8))
    law = law_named("exponential", 0.05, 0.4)
    solver = Bpx(Problem(Grid((8, 8), (1.0, 1.0)), heights, 0.05, attraction=law))
    guard = SaddleGuard(solver, branch)
    monkeypatch.setattr(guard, "_work_along", lambda mode: (0.0, 1.0))
    monkeypatch.setattr(guard, "_gain_along", lambda mode, length: -(length**2))
    assert np.sign(guard._length_of_kick(heights)) == side
