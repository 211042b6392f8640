"""Prescribed areas against what loads give: jumps are real, or none is told of; and full contact
only where it is."""

import numpy as np
import pytest
from campaign.truth import Contact
from contacts import field, random_heights, sweep_over

import hpc_gfmd
from hpc_gfmd.driver.load import Load


def plateau_of_fine_texture(n):
    """A texture of 1e-6 beside grooves of depth 3, as floats of single precision hardly know it."""
    z = 1e-6 * random_heights((n, n), seed=1)
    z[::8] -= 3.0
    return z


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("share", [0.02, 0.1])
def test_an_area_of_heights_that_single_precision_cannot_tell_apart(share):
    """The load is solved in double precision, and the heights are compared in it."""
    found = hpc_gfmd.solve(plateau_of_fine_texture(64), a_r=share, accuracy=1e-3)
    assert found.status == "converged"
    assert abs(found.a_r * 64**2 - share * 64**2) <= max(1.001, 1e-3 * share * 64**2)


@pytest.mark.parametrize(("seed", "share"), [(1, 0.8715), (3, 0.6536), (5, 0.5849), (6, 0.8513)])
@pytest.mark.parametrize("accuracy", [1e-4, 1e-6])
def test_no_jump_of_a_wall_without_symmetry(seed, share, accuracy):
    """Points of a rough wall change sides one by one, however steep the curve is."""
    wall = hpc_gfmd.make_surface(
        "self-affine", hurst=0.3, L_over_lam_l=1, lam_l_over_lam_s=32, lam_s_over_a=2, seed=seed
    )
    found = hpc_gfmd.solve(wall.heights, a_r=share, physical_sizes=wall.sizes, accuracy=accuracy)
    points = wall.heights.size
    assert found.status == "converged"
    assert "jumps" not in (found.note or "")
    assert abs(found.a_r - share) * points <= max(1.001, accuracy * share * points)


@pytest.mark.parametrize("unlike", [0.0, 1e-7, 1e-4])
def test_alike_and_nearly_alike_peaks(unlike):
    """Peaks of one height touch at once; where they differ by next to nothing, one by one."""
    rng = np.random.default_rng(0)
    z = np.full((32, 32), -1.0)
    z[::8, ::8] = 0.0
    z[4::8, 4::8] = -0.05 + unlike * rng.standard_normal((4, 4))
    wanted = 24
    found = sweep_over(z, accuracy=1e-3).solve(Load("a_r", wanted / z.size))
    assert found.status == "converged"
    if unlike:
        assert abs(found.contact_points - wanted) <= 1
    else:
        assert found.contact_points in (16, 32)
        assert "a_r jumps from 0.01562 to 0.03125" in found.note


def test_a_wall_that_varies_along_one_axis():
    """Points along the other axis touch together: between their areas it jumps, which is said."""
    profile = random_heights((1, 64), seed=4)
    z = np.repeat(profile, 48, axis=0)
    found = sweep_over(z, accuracy=1e-3).solve(Load("a_r", 10.4 / 64))
    assert found.status == "converged"
    assert found.contact_points == 10
    assert "a_r jumps from 0.1562 to 0.1719" in found.note


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("below", [1e-9, 3e-8, 1e-7, 1e-6])
@pytest.mark.parametrize("precision", ["auto", "single", "double"])
@pytest.mark.parametrize("n", [16, 48])
def test_a_last_open_point(n, precision, below):
    """Just below the load that closes the gap one point is open; its gap is known by hand. Single
    precision cannot know that, and says so."""
    z = np.random.default_rng(0).standard_normal((n, n))
    sweep = sweep_over(z, accuracy=1e-8)
    closed = sweep.solve(Load("a_r", 1.0))
    stiffness = float(sweep.working.model.body.near(sweep.surface.grid)[0])
    p = field(closed, "pressure").ravel()
    closing = closed.p_mean - p.min()
    if np.sort(p)[1] - p.min() < 2 * below * closing:
        pytest.skip("two points open")
    gap = below * closing / sweep.working.pressure_unit / stiffness / n**2
    gap *= sweep.surface.height_unit
    found = hpc_gfmd.solve(z, closing * (1 - below), accuracy=1e-3, precision=precision)
    if found.status == "converged":
        assert found.a_r * n**2 == pytest.approx(n**2 - 1)
        assert found.gap_mean == pytest.approx(gap, rel=1e-3 + 1e-13 / below)
    else:
        assert precision == "single"
        assert not max(found.errors) < 1e-3


def test_an_area_of_less_than_two_points():
    found = sweep_over(random_heights((24, 24), seed=3), accuracy=1e-3).solve(
        Load("a_r", 1.4 / 576)
    )
    assert found.status == "converged"
    assert found.contact_points in (1, 2)
    assert "1.4 points" in found.note


@pytest.mark.parametrize("share", [0.6 / 64, 1 / 64, 1.3 / 64])
def test_the_first_line_of_a_wall_that_varies_along_one_axis(share):
    z = np.repeat(random_heights((1, 64), seed=4), 48, axis=0)
    found = sweep_over(z, accuracy=1e-3).solve(Load("a_r", share))
    assert found.status == "converged"
    assert found.contact_points == 1


def test_less_than_half_a_line_of_a_wall_that_varies_along_one_axis():
    z = np.repeat(random_heights((1, 64), seed=4), 48, axis=0)
    with pytest.raises(hpc_gfmd.SceneError, match=r"load\.a_r: found 0\.005, .* 64 lines"):
        hpc_gfmd.solve(z, a_r=0.005)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("lower", [1e-2, 1e-4])
@pytest.mark.parametrize("beyond", [2e-9, 1e-7, 1e-5])
def test_a_second_point_that_just_touches(lower, beyond):
    """Two tall points, one a little lower: how many touch is right, or known to be doubtful."""
    z = random_heights((32, 32), seed=5)
    z[3, 5], z[9, 21] = z.max() + 5, z.max() + 5 - lower
    exact = Contact(z, (1.0, 1.0))
    heights = exact.height_unit
    # S between the points, from a unit load on the first
    load = np.zeros(z.shape)
    load[3, 5] = 1.0
    S = exact.times(exact.S, load)
    touching = lower / heights / (S[3, 5] - S[9, 21]) / z.size
    p_star = touching * (1 + beyond)
    truth = exact.solve(p_star)
    for accuracy in (1e-1, 1e-3):
        found = hpc_gfmd.solve(z, p_star * exact.g_rms, accuracy=accuracy)
        off = abs(round(found.a_r * z.size) - truth.contact) / truth.contact
        assert off <= found.errors[0] + 1e-9
