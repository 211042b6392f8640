"""The jump of an area that is seen before it is solved for."""

from types import SimpleNamespace

import numpy as np
import pytest

from hpc_gfmd.driver.staircase import Staircase
from hpc_gfmd.kernels.margins import NUMBERS, count_margins, number_of
from hpc_gfmd.parallel.comm import SerialComm


def state(pressures, gaps, dtype=np.float64):
    """A solver's state of points in contact, in a row above points out of it; columns beyond them
    are not of the surface."""
    n = max(len(pressures), len(gaps)) + 2
    g, p = np.full((2, n), 9.0, dtype), np.full((2, n), -1.0, dtype)
    g[0, : len(pressures)], p[0, : len(pressures)], g[1, : len(gaps)] = 0.0, pressures, gaps
    return SimpleNamespace(g=g, p=p, grid=SimpleNamespace(inside=(2, n), comm=SerialComm()))


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_numbers(dtype):
    """Each point is counted once, by a number that is its pressure or gap to 1/128; a point without
    pressure counts as open."""
    rng = np.random.default_rng(1)
    pressures, gaps = rng.lognormal(0, 3, 50), rng.lognormal(-20, 3, 40)
    solver = state([*pressures, 0.0], gaps, dtype)
    for closed, there in ((True, pressures), (False, [*gaps, 0.0])):
        counts = np.zeros(NUMBERS, np.int64)
        count_margins(solver.g, solver.p, solver.grid.inside, closed, counts)
        finite = np.arange(2**15 - 2**7)
        found, there = np.repeat(number_of(finite), counts[finite])[: len(there)], np.sort(there)
        assert counts.sum() == (50 if closed else solver.g.size - 50)
        assert np.all((found <= there * (1 + 1e-6)) & (found >= there * (1 - 1 / 128)))


def test_a_zero_may_have_a_sign():
    """It is counted as any other, and nothing is counted beside the counts."""
    counts = np.zeros(NUMBERS + 1, np.int64)
    count_margins(
        np.array([[-0.0, 0.0, -1.0, 5.0]]), np.zeros((1, 4)), (1, 3), False, counts[:NUMBERS]
    )
    assert (counts[0], counts[NUMBERS]) == (3, 0)


def next_jump(solver, contact, points, rate, error):
    return Staircase.of(solver, contact, points, rate).jump(abs(points), error)


def edges(rng, peaks, alike):
    """Pressures of 400 points and gaps of as many: next to the edges of so many peaks, which are
    alike or not."""
    places = (
        np.arange(400 // peaks) + rng.random((1, 400 // peaks) if alike else (peaks, 400 // peaks))
    ).ravel()
    places = np.tile(places, peaks) if alike else places
    return np.sqrt(places + 0.1), (places + 0.1) ** 1.5 / 50


@pytest.mark.parametrize("sign", [1, -1])
def test_points_that_are_alike_go_at_once(sign):
    """Sixteen equal peaks: between two of their points there is a jump of sixteen, of different
    ones there is none."""
    rng = np.random.default_rng(2)
    solver = state(*edges(rng, 16, True))
    jump = next_jump(solver, 400, sign * 25, 400, 1e-3)
    assert (jump.before, jump.after) == (16, 32)
    assert 0 < jump.to_before < jump.to_after < 0.5
    first = next_jump(solver, 400, sign * 7.5, 400, 1e-3)
    assert (first.before, first.after, first.to_before) == (0, 16, 0)
    assert next_jump(state(*edges(rng, 16, False)), 400, sign * 25, 400, 1e-3) is None
    assert Staircase.of(solver, 400, sign * 1000, 400) is None, "there are not so many"


def test_what_a_rough_solution_cannot_tell():
    """Where the error of the pressure is as large as the way to the next points, nothing is
    said."""
    solver = state(*edges(np.random.default_rng(3), 16, True))
    assert next_jump(solver, 400, 25, 400, 0.3) is None


@pytest.mark.parametrize("sign", [1, -1])
def test_how_far_it_is_where_all_go_in_steps(sign):
    """By no usual rate: points leave a contact where its mean pressure has fallen by about theirs;
    a gap closes where it has risen by about what presses a point so far."""
    solver = state([0.2] * 100 + [0.9] * 300, [0.3] * 100 + [0.8] * 100)
    solver.p0, solver.grid.N, solver.problem = (
        0.1,
        1600,
        SimpleNamespace(body=SimpleNamespace(scale=lambda grid: 5.0)),
    )
    ways = [Staircase.of(solver, 400, sign * 30, rate).way[0] for rate in (100, 10_000)]
    assert ways == pytest.approx([0.6 * (0.6 if sign > 0 else 0.2) / 0.4] * 2, rel=0.02)
