"""Prescribed areas: jumps are reported only where they exist, and full contact only where it is."""

import numpy as np
import pytest
from campaign.run import ways
from campaign.solving import rows_of
from campaign.table import failures
from campaign.truth import Contact
from contacts import field, random_heights, sweep_over

import hpc_gfmd
from hpc_gfmd.driver.load import Load


@pytest.mark.quick
@pytest.mark.parametrize(
    "name",
    [
        "target_area_bricks",
        "target_area_texture",
        "target_area_tall_point",
        "target_area_steep",
        "target_hard_area",
        "target_hard_gap",
    ],
)
def test_walls_of_the_campaign(name):
    """Areas and gaps are those of an active set, or next to a jump of its area."""
    rows = rows_of(name, 2311, 0, ways(["bpx"], ["auto"], [1e-3], "no"))
    assert {row["status"] for row in rows} == {"converged"}
    assert not failures(rows)
    assert name != "target_area_bricks" or any(row["jump"] for row in rows)


@pytest.mark.parametrize("spread", [0.0, 1e-7, 1e-4])
def test_equal_and_nearly_equal_peaks(spread):
    """Peaks of equal height touch together, or not; if heights differ at all, one by one."""
    rng = np.random.default_rng(0)
    z = np.full((32, 32), -1.0)
    z[::8, ::8] = 0.0
    z[4::8, 4::8] = -0.05 + spread * rng.standard_normal((4, 4))
    target = 22
    contact = sweep_over(z, accuracy=1e-3).solve(Load("a_r", target / z.size))
    assert contact.status == "converged"
    if spread:
        assert abs(contact.contact_points - target) <= 1
    else:
        assert contact.contact_points == 16  # the nearer
        jump = "a_r jumps from 0.01562 to 0.03125"
        assert contact.note.endswith(f"; {jump}: the nearer is taken")
        single = sweep_over(z, accuracy=1e-3, precision="single")
        in_single = single.solve(Load("a_r", target / z.size))
        assert in_single.note.endswith(f"; single precision cannot tell whether {jump}")


def test_an_area_of_less_than_two_points():
    sweep = sweep_over(random_heights((24, 24), seed=3), accuracy=1e-3)
    contact = sweep.solve(Load("a_r", 1.4 / 576))
    assert contact.status == "converged"
    assert contact.contact_points in (1, 2)
    assert "1.4 points" in contact.note


def test_an_area_of_less_than_a_point_is_one_point():
    """Of two points one would be too many, though it is one more than the least of any load."""
    z = np.array([[1.08032296], [1.8991886], [-2.49164816]])
    solution = hpc_gfmd.solve(z, a_r=0.2937, boundary="periodic", hardness=0.267)
    assert solution.a_r == pytest.approx(1 / 3)
    assert solution.p < hpc_gfmd.solve(z, a_r=0.6, boundary="periodic", hardness=0.267).p


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
