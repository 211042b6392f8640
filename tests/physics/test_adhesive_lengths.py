"""Contacts with attraction at a mean gap or an approach: held by a spring, they pass through what
is a jump under a load."""

import adhesive
import numpy as np
import oracle
import pytest
from adhesive_forms import AdhesiveWave
from scipy.linalg import eigh, null_space

import hpc_gfmd


def test_a_wave_is_held_beyond_its_pull_off():
    """Larger gaps at smaller pulls, near Johnson's curve, at which no load holds it; at last it
    comes apart."""
    n, work, ell = 512, (0.3 * np.pi) ** 2 / 2, 0.02
    z = np.cos(2 * np.pi * np.arange(n) / n)[:, None]
    how = {
        "physical_sizes": (1.0, 1.0 / n),
        "adhesion": {"work": work, "range": float(np.sqrt(ell * work))},
        "branch": "retraction",
        "fields": (),
    }
    gaps = [0.36, 1.0, 1.2, 1.28, 1.32, 1.36, 1.6, 1.7]
    found = hpc_gfmd.solve(z, gap_mean=gaps, **how)
    assert [one.status for one in found] == ["converged"] * 6 + ["separated"] * 2
    assert all("too far apart" in one.note for one in found[6:])
    held, exact = found[:6], AdhesiveWave(work)
    pulls = [-one.p / exact.p_full for one in held]
    for one, gap in zip(held, gaps, strict=False):
        assert one.gap_mean == pytest.approx(gap, rel=1e-3)
        assert max(one.errors) < 1e-3
        assert one.value("stability") > 0
    assert max(pulls) == pulls[3] == pytest.approx(-exact.pull_off / exact.p_full, rel=0.015)
    assert pulls[3] > pulls[4] > pulls[5] + 0.004
    assert pulls[5] == pytest.approx(0.0881, rel=0.01)
    assert found.pull_off == found[3].p
    by_load = hpc_gfmd.solve(z, [one.p for one in held[:4]], **how)
    for one, same in zip(held, by_load[:3], strict=False):
        assert same.a_r == pytest.approx(one.a_r, rel=2e-2)
        assert same.gap_mean == pytest.approx(one.gap_mean, rel=5e-3)


@pytest.mark.parametrize("precision", ["single", "double"])
def test_a_ball_at_an_approach(precision):
    """The forces that give these approaches come out again, and an approach below 0 is held."""
    w = 0.12**3 * 2 / (9 * np.pi)
    ball = hpc_gfmd.make_surface(
        "sphere", radius=1.0, n=(64, 64), physical_sizes=(1.0, 1.0), boundary="free"
    )
    how = {
        "adhesion": {"work": w, "range": float(np.cbrt(w**2))},  # Tabor's parameter is 1
        "branch": "retraction",
        "precision": precision,
        "fields": (),
    }
    forces = [float(force * np.pi * w) for force in (0.5, 0.0, -1.2, -1.5)]
    pulled = hpc_gfmd.solve(ball, force=forces, **how)
    approaches = [float(one.value("approach")) for one in pulled]
    assert approaches[-1] < 0 < approaches[-2]
    found = hpc_gfmd.solve(ball, approach=approaches, **how)
    for one, same, approach in zip(found, pulled, approaches, strict=True):
        assert one.status == "converged"
        assert one.value("approach") == pytest.approx(approach, abs=2e-3 * approaches[0])
        assert one.p == pytest.approx(same.p, abs=4e-3 * np.pi * w)
        assert one.a_r == pytest.approx(same.a_r, abs=3 / 64**2)
    last = hpc_gfmd.solve(ball, approach=[approaches[0], 0, -0.05, -0.06], **how)[1:]
    assert [one.status for one in last] == ["converged", "separated", "separated"]
    assert found[-2].p > last[0].p > found[-1].p
    assert last[0].value("approach") == pytest.approx(0, abs=1e-3 * how["adhesion"]["range"])


@pytest.mark.parametrize("branch", ["approach", "retraction"])
def test_a_rough_wall_at_mean_gaps(branch):
    """The pressures that give these gaps come out again, those that pull included."""
    wall, adhesion = adhesive.wall(4, 4), adhesive.attraction(0.5, 0.1)
    how = {"adhesion": adhesion, "precision": "double", "fields": (), "accuracy": 1e-4}
    pressures = [0.3, 0.05, 0.0, -0.001]
    pulled = hpc_gfmd.solve(wall, pressures, branch="retraction", **how)
    gaps = [float(one.gap_mean) for one in pulled]
    found = hpc_gfmd.solve(wall, gap_mean=gaps, branch=branch, unique=True, **how)
    for one, same in zip(found, pulled, strict=True):
        assert one.status == "converged"
        assert one.gap_mean == pytest.approx(same.gap_mean, rel=1e-4)
        assert one.p == pytest.approx(same.p, rel=2e-3, abs=1e-5)
        assert one.a_r == pytest.approx(same.a_r, abs=2 / 32**2)
        assert one.value("unique") in (0, 1)


def test_a_gap_at_which_the_bodies_touch_is_never_separated():
    """On its way to a small gap the search pulls the bodies apart, and brings them back."""
    wall = adhesive.wall(8, 8)
    heights = np.asarray(wall.heights)
    touching = heights.max() - heights.mean()
    gaps = [0.02 * touching, 0.1 * touching, 0.9 * touching]
    found = hpc_gfmd.solve(
        wall,
        gap_mean=gaps,
        adhesion=adhesive.attraction(1.0, 0.3),
        branch="retraction",
        accuracy=1e-2,
        fields=(),
    )
    assert [one.status for one in found] == ["converged"] * 3
    for one, gap in zip(found, gaps, strict=True):
        assert one.gap_mean == pytest.approx(gap, rel=1e-2)
        assert one.p < 0 < one.a_r


def test_a_gap_that_the_contact_jumps_past():
    """Where no spring of the search holds the gap it gives up, and says so."""
    groove = np.zeros((9, 9))
    groove[:, :3] = -0.77
    groove += 1e-3 * np.random.default_rng(0).standard_normal((9, 9))
    how = {"adhesion": {"work": 217.0, "range": 1.3245}, "fields": ()}
    with pytest.warns(hpc_gfmd.NotConverged, match="stagnated"):
        found = hpc_gfmd.solve(groove, gap_mean=0.0775, boundary=["free", "periodic"], **how)
    assert "the contact jumps past the prescribed value" in found.note
    assert found.fft_pairs < 1500


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
    found = hpc_gfmd.solve(ball, gap_mean=gap, adhesion=attraction, boundary="periodic")
    assert found.status == "converged"
    assert found.gap_mean == pytest.approx(gap, rel=1e-3)
    assert found.p == pytest.approx(-0.646, abs=5e-3)
    assert stability_at(found, work, reach) > 0
    assert found.fft_pairs < 400


@pytest.mark.parametrize("noise", [0.0, 1e-8])
def test_a_symmetric_wall_is_left_where_the_symmetric_state_is_a_saddle(noise):
    """A cylinder: the state that is uniform along it has a stability of -0.16."""
    n, work, reach = 16, 1.1213e-4, 2.59e-3
    x = np.arange(n) / n - 0.5
    heights = -0.02 * np.add.outer(x * x, 0 * x)
    gap = 0.5966 * (heights.max() - heights.mean())
    heights += noise * np.random.default_rng(1).standard_normal(heights.shape)
    found = hpc_gfmd.solve(
        heights,
        gap_mean=gap,
        adhesion={"work": work, "range": reach},
        accuracy=1e-5,
        boundary="periodic",
    )
    assert found.status == "converged"
    assert found.p == pytest.approx(-0.01794, rel=1e-3)
    assert stability_at(found, work, reach) > 0.1
