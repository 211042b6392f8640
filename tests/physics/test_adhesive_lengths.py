"""Contacts with attraction at a mean gap or an approach: held by a spring, they pass through what
is a jump under a load."""

import adhesive
import numpy as np
import oracle
import pytest
from scipy.linalg import eigh, null_space

import hpc_gfmd


def test_a_wave_is_held_beyond_its_pull_off():
    """Larger gaps at smaller pulls, near Johnson's curve, at which no load holds it; at last it
    comes apart."""
    wave, exact = adhesive.wave(0.02, 512)
    gaps = [0.36, 1.0, 1.2, 1.28, 1.32, 1.36, 1.6, 1.7]
    solutions = hpc_gfmd.solve(**wave, gap_mean=gaps, branch="retraction")
    assert [load.status for load in solutions] == ["converged"] * 6 + ["separated"] * 2
    assert all("too far apart" in load.note for load in solutions[6:])
    held = solutions[:6]
    pulls = [-load.p / exact.p_full for load in held]
    for load, gap in zip(held, gaps, strict=False):
        assert load.gap_mean == pytest.approx(gap, rel=1e-3)
        assert max(load.errors) < 1e-3
        assert load.value("stability") > 0
    assert max(pulls) == pulls[3] == pytest.approx(-exact.pull_off / exact.p_full, rel=0.015)
    assert pulls[3] > pulls[4] > pulls[5] + 0.004
    assert pulls[5] == pytest.approx(0.0881, rel=0.01)
    assert solutions.pull_off == solutions[3].p
    pressures = [load.p for load in held[:4]]
    by_load = hpc_gfmd.solve(**wave, pressure=pressures, branch="retraction")
    for load, under_load in zip(held, by_load[:3], strict=False):
        assert under_load.a_r == pytest.approx(load.a_r, rel=2e-2)
        assert under_load.gap_mean == pytest.approx(load.gap_mean, rel=5e-3)


@pytest.mark.parametrize("precision", ["single", "double"])
def test_a_ball_at_an_approach(precision):
    """The forces that give these approaches come out again, and an approach below 0 is held."""
    ball, adhesion, jkr = adhesive.ball(64)
    how = {"adhesion": adhesion, "branch": "retraction", "precision": precision, "fields": ()}
    forces = [float(force * np.pi * jkr.w) for force in (0.5, 0.0, -1.2, -1.5)]
    pulled = hpc_gfmd.solve(ball, force=forces, **how)
    approaches = [float(load.value("approach")) for load in pulled]
    assert approaches[-1] < 0 < approaches[-2]
    solutions = hpc_gfmd.solve(ball, approach=approaches, **how)
    for load, expected, approach in zip(solutions, pulled, approaches, strict=True):
        assert load.status == "converged"
        assert load.value("approach") == pytest.approx(approach, abs=2e-3 * approaches[0])
        assert load.p == pytest.approx(expected.p, abs=4e-3 * np.pi * jkr.w)
        assert load.a_r == pytest.approx(expected.a_r, abs=3 / 64**2)
    ends = hpc_gfmd.solve(ball, approach=[approaches[0], 0, -0.05, -0.06], **how)[1:]
    assert [load.status for load in ends] == ["converged", "separated", "separated"]
    assert solutions[-2].p > ends[0].p > solutions[-1].p
    assert ends[0].value("approach") == pytest.approx(0, abs=1e-3 * adhesion["range"])


@pytest.mark.parametrize(("seed", "gap"), [(0, 0.05), (3, 0.03), (12, 0.05), (20, 1.6e-4)])
@pytest.mark.parametrize("accuracy", [1e-2, 1e-3])
def test_the_error_of_a_pressure_contains_the_gap_that_is_missed(seed, gap, accuracy):
    wall = hpc_gfmd.make_surface(
        "self-affine", hurst=0.8, L_over_lam_l=2, lam_l_over_lam_s=8, lam_s_over_a=4, seed=seed
    )
    keys = {"gap_mean": gap, "adhesion": {"work": 0.002, "range": 0.02}, "fields": ()}
    exact = hpc_gfmd.solve(wall, **keys, accuracy=1e-6)
    solution = hpc_gfmd.solve(wall, **keys, accuracy=accuracy)
    bar = solution.value("p_error")
    assert abs(exact.p / solution.p - 1) < bar < 60 * accuracy


@pytest.mark.parametrize("branch", ["approach", "retraction"])
def test_a_rough_wall_at_mean_gaps(branch):
    """The pressures that give these gaps come out again, those that pull included."""
    wall, adhesion = adhesive.wall(4, 4), adhesive.attraction(0.5, 0.1)
    how = {"adhesion": adhesion, "precision": "double", "fields": (), "accuracy": 1e-4}
    pressures = [0.3, 0.05, 0.0, -0.001]
    pulled = hpc_gfmd.solve(wall, pressures, branch="retraction", **how)
    gaps = [float(load.gap_mean) for load in pulled]
    solutions = hpc_gfmd.solve(wall, gap_mean=gaps, branch=branch, unique=True, **how)
    for load, expected in zip(solutions, pulled, strict=True):
        assert load.status == "converged"
        assert load.gap_mean == pytest.approx(expected.gap_mean, rel=1e-4)
        assert load.p == pytest.approx(expected.p, rel=2e-3, abs=1e-5)
        assert load.a_r == pytest.approx(expected.a_r, abs=2 / 32**2)
        assert load.value("unique") in (0, 1)


def test_a_gap_at_which_the_bodies_touch_is_never_separated():
    """On its way to a small gap the search pulls the bodies apart, and brings them back."""
    wall = adhesive.wall(8, 8)
    heights = np.asarray(wall.heights)
    touching = heights.max() - heights.mean()
    gaps = [0.02 * touching, 0.1 * touching, 0.9 * touching]
    solutions = hpc_gfmd.solve(
        wall,
        gap_mean=gaps,
        adhesion=adhesive.attraction(1.0, 0.3),
        branch="retraction",
        accuracy=1e-2,
        fields=(),
    )
    assert [load.status for load in solutions] == ["converged"] * 3
    for load, gap in zip(solutions, gaps, strict=True):
        assert load.gap_mean == pytest.approx(gap, rel=1e-2)
        assert load.p < 0 < load.a_r


def test_a_gap_that_the_contact_jumps_past():
    """Where no spring of the search holds the gap it gives up, and says so."""
    groove = np.zeros((9, 9))
    groove[:, :3] = -0.77
    groove += 1e-3 * np.random.default_rng(0).standard_normal((9, 9))
    how = {"adhesion": {"work": 217.0, "range": 1.3245}, "fields": ()}
    with pytest.warns(hpc_gfmd.NotConverged, match="stagnated"):
        solution = hpc_gfmd.solve(groove, gap_mean=0.0775, boundary=["free", "periodic"], **how)
    assert "the contact jumps past the prescribed value" in solution.note
    assert solution.fft_pairs < 1500


def stability_at(solution, work, reach):
    """The smallest eigenvalue of K + phi'' over K on the open points at a fixed mean gap."""
    is_open = np.asarray(solution.pressure).ravel() == 0
    K = oracle.stiffness(solution.pressure.shape)[np.ix_(is_open, is_open)]
    gap = np.asarray(solution.gap, float).ravel()[is_open]
    H = K - np.diag(work / reach**2 * np.exp(-gap / reach))
    Z = null_space(np.ones((1, is_open.sum())))
    return eigh(Z.T @ H @ Z, Z.T @ K @ Z, eigvals_only=True)[0]


def test_a_ball_whose_contact_jumps_with_a_soft_spring():
    """Strong attraction closes the gap at once; a stiffer spring holds a stable state."""
    x = (np.arange(24) + 0.5) / 24 - 0.5
    ball = -0.1 * np.add.outer(x * x, x * x)
    gap = 0.5 * (ball.max() - ball.mean())
    reach = np.ptp(ball)
    work = 9 * np.pi * reach**2
    attraction = {"work": work, "range": reach}
    solution = hpc_gfmd.solve(ball, gap_mean=gap, adhesion=attraction, boundary="periodic")
    assert solution.status == "converged"
    assert solution.gap_mean == pytest.approx(gap, rel=1e-3)
    assert solution.p == pytest.approx(-0.646, abs=5e-3)
    assert stability_at(solution, work, reach) > 0
    assert solution.fft_pairs < 400


@pytest.mark.parametrize("noise", [0.0, 1e-8])
def test_a_symmetric_wall_is_left_where_the_symmetric_state_is_a_saddle(noise):
    """A cylinder: the state that is uniform along it has a stability of -0.16."""
    n, work, reach = 16, 1.1213e-4, 2.59e-3
    x = np.arange(n) / n - 0.5
    heights = -0.02 * np.add.outer(x * x, 0 * x)
    gap = 0.5966 * (heights.max() - heights.mean())
    heights += noise * np.random.default_rng(1).standard_normal(heights.shape)
    solution = hpc_gfmd.solve(
        heights,
        gap_mean=gap,
        adhesion={"work": work, "range": reach},
        accuracy=1e-5,
        boundary="periodic",
    )
    assert solution.status == "converged"
    assert solution.p == pytest.approx(-0.01794, rel=1e-3)
    assert stability_at(solution, work, reach) > 0.1
