"""Partial slip: the ball of Mindlin and Deresiewicz, and what holds for any path."""

import numpy as np
import pytest
from contacts import rough_wall
from refusal import refused

import hpc_gfmd
from hpc_gfmd.runs.slip import states_of

MU = 0.5


@pytest.mark.parametrize(
    ("n", "tolerance"), [(64, 5e-4), pytest.param(128, 1.2e-4, marks=pytest.mark.slow)]
)
def test_a_ball_under_an_oscillating_load(n, tolerance):
    """Mindlin, Deresiewicz (1953): shift and loss of a cycle of 0.8 times sliding."""
    R, top, X = 10.0, 0.045, 0.8
    x = (np.arange(n) + 0.5) / n * 2 - 1
    z = -(x[:, None] ** 2 + x**2) / 2 / R
    P = 4 / 3 * np.sqrt(R) * top**1.5
    up = np.arange(1, 9) / 4
    y = X * np.concatenate([up[:4], 1 - up, up - 1, 1 - up])
    path = hpc_gfmd.slip(MU, P, MU * P * y)
    assert len(path.loads) == 9
    solutions = hpc_gfmd.solve(
        z, force=path.loads, physical_sizes=(2, 2), boundary="free", accuracy=1e-5
    )
    result = path.of(solutions)
    whole = MU * solutions[-1].value("approach")  # shift at sliding

    def first(v):
        return 1 - (1 - v) ** (2 / 3)

    exact = np.concatenate(
        [
            first(y[:4]),
            first(X) - 2 * first((X - y[4:12]) / 2),
            2 * first((X + y[12:20]) / 2) - first(X),
            first(X) - 2 * first((X - y[20:]) / 2),
        ]
    )
    assert np.abs(result.shift / whole - exact).max() < tolerance
    lost = 24 / 5 * (1 - (1 - X) ** (5 / 3) - 5 * X / 6 * (1 + (1 - X) ** (2 / 3)))
    assert result.loss(X * MU * P) * 4 / (MU * P * whole) == pytest.approx(lost, rel=1e-3)
    traction = result.traction(5)
    assert 4 * traction.mean() == pytest.approx(MU * P * y[5], rel=1e-5)
    assert (np.abs(traction) <= MU * solutions[-1].pressure * (1 + 1e-6) + 1e-9).all()
    assert (np.diff(result.slip_area[:4]) > 0).all()
    assert result.slip_area[3] == result.slip_area[11]  # fully turned


@pytest.mark.parametrize("seed", range(3))
def test_any_path_is_balanced_and_does_not_slide(seed):
    """The parts fill the contact, carry T, and have at most the friction of their pressure."""
    rng = np.random.default_rng(seed)
    normal = rng.uniform(0.1, 1, 200)
    tangential = rng.uniform(-1, 1, 200) * MU * normal
    states = states_of([*zip(normal.tolist(), tangential.tolist())], MU)
    for state, P, T in zip(states, normal, tangential, strict=True):
        lows, highs, shares = np.array(state.parts).T
        assert sum(shares * (highs - lows)) == pytest.approx(T, abs=1e-12)
        assert np.abs(shares).max() <= MU * (1 + 1e-12)
        assert (highs[0], lows[-1]) == (P, pytest.approx(0, abs=1e-15))
        assert lows[:-1] == pytest.approx(highs[1:])
        assert 0 <= state.edge <= P


@pytest.mark.parametrize("friction", [0.1, 0.8])
def test_the_loss_is_the_area_of_the_loop(friction):
    P = 0.15
    sweep = 0.7 * friction * P * np.cos(np.pi * np.arange(41) / 20)  # a cycle from the largest T
    path = hpc_gfmd.slip(friction, P, sweep)
    result = path.of(hpc_gfmd.solve(rough_wall((2, 8, 2)), path.loads, accuracy=1e-5))
    loop = np.trapezoid(sweep, result.shift)
    assert result.loss(sweep[0]) == pytest.approx(loop, rel=0.01)


@pytest.mark.parametrize("share", [0.01, 0.1, 0.5])
def test_errors_contain_what_a_better_accuracy_changes(share):
    T = share * MU * 0.15
    path = hpc_gfmd.slip(MU, 0.15, [T])
    rough, exact = (
        path.of(hpc_gfmd.solve(rough_wall((2, 8, 2)), path.loads, accuracy=accuracy))
        for accuracy in (1e-3, 1e-7)
    )
    assert 0.01 < abs(rough.shift[0] - exact.shift[0]) / rough.shift_error[0] < 1
    assert abs(rough.loss(T) - exact.loss(T)) < rough.loss_error(T) * abs(rough.loss(T))
    assert exact.loss_error(T) < rough.loss_error(T)


def test_loads_that_rise_together_do_not_slip():
    """All contact sticks, and the traction is dT/dP times the pressure of new contact."""
    wall = rough_wall((2, 8, 2))
    P = np.array([0.05, 0.1, 0.15])
    T = 0.3 * (P - 0.05)
    path = hpc_gfmd.slip(MU, P, T)
    solutions = hpc_gfmd.solve(wall, path.loads)
    result = path.of(solutions)
    assert result.slip_area == pytest.approx(0)
    new = solutions[-1].pressure - solutions[0].pressure
    assert result.traction(2) == pytest.approx(0.3 * new, abs=1e-12)
    fallen = solutions[0].gap_mean - solutions[-1].gap_mean
    assert result.shift[2] == pytest.approx(0.3 * fallen)


def test_full_sliding_of_a_periodic_wall():
    """The shift is friction times the compression since the first touch."""
    wall = rough_wall((2, 8, 2))
    path = hpc_gfmd.slip(MU, 0.1, [0.1 * MU], nu=0.3)
    result = path.of(hpc_gfmd.solve(wall, path.loads))
    (solution,) = hpc_gfmd.solve(wall, [0.1])
    fallen = -wall.heights.mean() + wall.heights.max() - solution.gap_mean
    assert result.shift[0] == pytest.approx(MU * 1.7 / 1.4 * fallen, rel=1e-6)
    assert result.slip_area[0] == solution.a_r
    assert result.traction(0) == pytest.approx(MU * solution.pressure)
    with refused("amplitude: found nan"):
        result.loss(np.nan)


REFUSED = [
    ((0.0, 1.0, [0.1]), "friction: found 0"),
    ((0.5, 1.0, [0.6]), "tangential: found 0.6, which slides, allowed: up to 0.5"),
    ((0.5, [1.0, 2.0], [0.1]), "normal: found 2 loads for 1"),
    ((0.5, "1 MPa", [0.1]), "other units"),
    ((0.5, "1 m", ["1 m"]), "normal: found '1 m'"),
    (("0.5", 1.0, [0.1]), "friction: found 0.5, allowed: a number"),
    ((np.inf, 1.0, [0.1]), "friction: found inf"),
    ((0.5, 1.0, [np.nan]), "tangential: found nan"),
    ((0.5, np.inf, [0.1]), "normal: found inf"),
    ((0.5, 1.0, [None]), "tangential: found None"),
    ((0.5, 1.0, [[0.1]]), r"tangential: found \[0.1\]"),
    ((0.5, 1.0, []), "tangential: found no loads"),
    ((0.5, [], [0.1]), "normal: found 0 loads for 1"),
    ((0.5, 1.0, [0.1], "0.3"), "nu: found 0.3, allowed: a number"),
]


def test_refused():
    for arguments, words in REFUSED:
        with refused(words):
            hpc_gfmd.slip(*arguments)


def test_solutions_of_something_else_are_refused():
    path = hpc_gfmd.slip(MU, "1 MPa", ["0.1 MPa", "0.2 MPa"])
    assert path.loads == ["600000.0 Pa", "800000.0 Pa", "1000000.0 Pa"]
    wall = rough_wall((2, 8, 2))
    with refused("other loads"):
        path.of(hpc_gfmd.solve(wall, ["1 MPa", "2 MPa"], "10 MPa"))
    with refused("material.hardness"):
        path.of(hpc_gfmd.solve(wall, path.loads, "10 MPa", hardness="5 MPa"))
