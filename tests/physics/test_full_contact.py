"""Full contact, which needs no iteration, and the loads at which it is reached."""

import numpy as np
import pytest
from contacts import random_heights, wave_numbers

import hpc_gfmd


@pytest.mark.parametrize("n", [(16, 16), (15, 12), (1, 16), (8, 1)])
def test_full_contact(n):
    z = random_heights(n)
    p_full = np.fft.ifft2(wave_numbers(n) / 2 * np.fft.fft2(z)).real * 5.0
    mean = -1.01 * p_full.min()
    solution = hpc_gfmd.solve(z, mean, E_star=5.0, accuracy=1e-3, precision="double")
    assert (solution.status, solution.iterations, solution.a_r, solution.gap_mean) == (
        "converged",
        0,
        1.0,
        0.0,
    )
    assert solution.fft_pairs <= 2
    error = np.abs(solution.pressure - mean - p_full).max()
    assert error < 1e-11 * np.abs(p_full).max()
    assert not solution.gap.any()
    assert solution.errors[:2] == (0, 0)
    assert error / np.sqrt(np.mean(solution.pressure**2)) < 10 * solution.errors[2] < 1e-13


@pytest.mark.parametrize(("n", "ulps"), [(16, -2), (16, 0), (16, 1), (102, 0), (244, 0)])
@pytest.mark.parametrize("unit", [1.0, 1e-3, 1e-12])
def test_the_load_that_just_closes_a_wave(n, ulps, unit):
    """At p = E* g_rms, where rounding errors must not open a gap, "auto" uses double precision."""
    x, y = (2 * np.pi * k * np.arange(n) / n for k in (1, 2))
    p_star = 1 + ulps * 2.0**-52
    z = unit * np.cos(x)[:, None] * np.cos(y)
    solution = hpc_gfmd.solve(z, p_star=p_star, accuracy=1e-3)
    assert (solution.status, solution.a_r, solution.gap_mean) == ("converged", 1.0, 0.0)
    assert solution.p_star == pytest.approx(p_star, rel=1e-15)


def test_the_area_of_all_points_in_double_precision():
    """The load that closes the gap is that of the heights in the precision of the solve."""
    z = np.cos(np.pi / 8 * np.arange(16))[:, None] + 1e-5 * random_heights((16, 32), 3)
    assert hpc_gfmd.solve(z, a_r=1.0, physical_sizes=(6.0, 1.0)).a_r == 1


@pytest.mark.parametrize("n", [(6, 6), (1, 1), (1, 5), (7, 4)])
def test_flat(n):
    solution = hpc_gfmd.solve(np.full(n, 3.0), 0.7)
    assert (solution.status, solution.iterations, solution.a_r, solution.gap_mean) == (
        "converged",
        0,
        1.0,
        0.0,
    )
    assert solution.errors == pytest.approx((0.0, 0.0, 0.0), abs=1e-15)
    assert solution.pressure == pytest.approx(np.full(n, 0.7))
    assert solution.pressure.shape == n


@pytest.mark.parametrize(("n", "below"), [(127, 1e-5), (256, 3e-6), (300, 1e-3)])
def test_a_pit_in_a_plate(n, below):
    """The gap of the last open point is (p_closed - p)/K_pp.

    "auto" uses double precision if rounding errors of single precision hide it; "single" does not
    claim a smaller error than it has.
    """
    z = np.zeros((n, n))
    z[n // 3, n // 4] = -1.0
    closing = np.fft.ifft2(wave_numbers(z.shape) / 2 * np.fft.fft2(-z)).real.max()
    for precision in ("auto", "single"):
        solution = hpc_gfmd.solve(z, closing * (1 - below), accuracy=1e-3, precision=precision)
        error = abs(solution.gap_mean / (below / n**2) - 1)
        assert solution.status == "converged" or precision == "single"
        assert error < solution.errors[1]
        assert error < 1e-3 or solution.status == "stagnated"
