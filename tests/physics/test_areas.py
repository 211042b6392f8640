"""Prescribed areas: jumps are reported only where they exist, and full contact only where it is."""

import numpy as np
import pytest
from campaign.truth import Contact
from contacts import field, random_heights, rough_wall, sweep_over

import hpc_gfmd
from hpc_gfmd.driver.load import Load


def plateau_of_fine_texture(n):
    """Return a texture of height 1e-6 beside grooves of depth 3, the limit of single precision."""
    z = 1e-6 * random_heights((n, n), seed=1)
    z[::8] -= 3.0
    return z


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("share", [0.02, 0.1])
def test_an_area_of_heights_that_single_precision_cannot_tell_apart(share):
    """The load is solved, and the heights are compared, in double precision."""
    wall = plateau_of_fine_texture(64)
    solution = hpc_gfmd.solve(wall, a_r=share, accuracy=1e-3, boundary="periodic")
    assert solution.status == "converged"
    assert abs(solution.a_r * 64**2 - share * 64**2) <= max(1.001, 1e-3 * share * 64**2)


@pytest.mark.parametrize(("seed", "share"), [(1, 0.8715), (3, 0.6536), (5, 0.5849), (6, 0.8513)])
@pytest.mark.parametrize("accuracy", [1e-4, 1e-6])
def test_no_jump_of_a_wall_without_symmetry(seed, share, accuracy):
    """Points of a rough surface come into contact one by one, however steep the curve is."""
    wall = rough_wall((1, 32, 2), hurst=0.3, seed=seed)
    solution = hpc_gfmd.solve(wall.heights, a_r=share, physical_sizes=wall.sizes, accuracy=accuracy)
    points = wall.heights.size
    assert solution.status == "converged"
    assert "jumps" not in (solution.note or "")
    assert abs(solution.a_r - share) * points <= max(1.001, accuracy * share * points)


@pytest.mark.parametrize("spread", [0.0, 1e-7, 1e-4])
def test_equal_and_nearly_equal_peaks(spread):
    """Peaks of equal height touch together; if their heights differ at all, one by one."""
    rng = np.random.default_rng(0)
    z = np.full((32, 32), -1.0)
    z[::8, ::8] = 0.0
    z[4::8, 4::8] = -0.05 + spread * rng.standard_normal((4, 4))
    target = 24
    contact = sweep_over(z, accuracy=1e-3).solve(Load("a_r", target / z.size))
    assert contact.status == "converged"
    if spread:
        assert abs(contact.contact_points - target) <= 1
    else:
        assert contact.contact_points in (16, 32)
        assert "a_r jumps from 0.01562 to 0.03125" in contact.note


def test_a_wall_that_varies_along_one_axis():
    """All points of a line touch together, so the area jumps, and a note reports it."""
    profile = random_heights((1, 64), seed=4)
    z = np.repeat(profile, 48, axis=0)
    contact = sweep_over(z, accuracy=1e-3).solve(Load("a_r", 10.4 / 64))
    assert contact.status == "converged"
    assert contact.contact_points == 10
    assert "a_r jumps from 0.1562 to 0.1719" in contact.note


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("below", [1e-9, 3e-8, 1e-7, 1e-6])
@pytest.mark.parametrize("precision", ["auto", "single", "double"])
@pytest.mark.parametrize("n", [16, 48])
def test_a_last_open_point(n, precision, below):
    """Just below the load that closes the gap one point is open, and its gap has a closed form.

    Single precision cannot resolve it and reports that it has not converged.
    """
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
    solution = hpc_gfmd.solve(z, closing * (1 - below), accuracy=1e-3, precision=precision)
    if solution.status == "converged":
        assert solution.a_r * n**2 == pytest.approx(n**2 - 1)
        assert solution.gap_mean == pytest.approx(gap, rel=1e-3 + 1e-13 / below)
    else:
        assert precision == "single"
        assert not max(solution.errors) < 1e-3


def test_an_area_of_less_than_two_points():
    sweep = sweep_over(random_heights((24, 24), seed=3), accuracy=1e-3)
    contact = sweep.solve(Load("a_r", 1.4 / 576))
    assert contact.status == "converged"
    assert contact.contact_points in (1, 2)
    assert "1.4 points" in contact.note


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("lower", [1e-2, 1e-4])
@pytest.mark.parametrize("beyond", [2e-9, 1e-7, 1e-5])
def test_a_second_point_that_just_touches(lower, beyond):
    """Of two tall points one is slightly lower: the number of contacts is right, or its estimated
    error covers the other one."""
    z = random_heights((32, 32), seed=5)
    top = z.max() + 5
    z[3, 5] = top
    z[9, 21] = top - lower
    exact = Contact(z, (1.0, 1.0))
    # S between the points, from a unit load on the first one
    load = np.zeros(z.shape)
    load[3, 5] = 1.0
    S = exact.times(exact.S, load)
    touching = lower / exact.height_unit / (S[3, 5] - S[9, 21]) / z.size
    p_star = touching * (1 + beyond)
    truth = exact.solve(p_star)
    for accuracy in (1e-1, 1e-3):
        solution = hpc_gfmd.solve(z, p_star * exact.g_rms, accuracy=accuracy)
        points = round(solution.a_r * z.size)
        assert abs(points - truth.contact) / truth.contact <= solution.errors[0] + 1e-9


def test_an_area_of_less_than_a_point_is_one_point():
    """Of two points one would be too many, though it is one more than the least of any load."""
    z = np.array([[1.08032296], [1.8991886], [-2.49164816]])
    solution = hpc_gfmd.solve(z, a_r=0.2937, boundary="periodic", hardness=0.267)
    assert solution.a_r == pytest.approx(1 / 3)
    assert solution.p < hpc_gfmd.solve(z, a_r=0.6, boundary="periodic", hardness=0.267).p
