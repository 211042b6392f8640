"""Full contact: known without iterating, std(p) = E* g_rms/2."""

import numpy as np
import pytest
from contacts import random_heights, wave_numbers

import hpc_gfmd


@pytest.mark.parametrize("n", [(16, 16), (15, 12), (1, 16), (8, 1)])
def test_full_contact(n):
    z = random_heights(n)
    p_full = np.fft.ifft2(wave_numbers(n) / 2 * np.fft.fft2(z)).real * 5.0
    mean = -1.01 * p_full.min()
    found = hpc_gfmd.solve(z, mean, E_star=5.0, accuracy=1e-3, precision="double")
    assert (found.status, found.iterations, found.a_r, found.gap_mean) == ("converged", 0, 1.0, 0.0)
    assert found.fft_pairs <= 2
    wrong = np.abs(found.pressure - mean - p_full).max()
    assert wrong < 1e-11 * np.abs(p_full).max()
    assert not found.gap.any()
    assert found.errors[:2] == (0, 0)
    assert wrong / np.sqrt(np.mean(found.pressure**2)) < 10 * found.errors[2] < 1e-13


@pytest.mark.parametrize(("n", "ulps"), [(16, -2), (16, 0), (16, 1), (102, 0), (244, 0)])
@pytest.mark.parametrize("unit", [1.0, 1e-3, 1e-12])
def test_the_load_that_just_closes_a_wave(n, ulps, unit):
    """E* g_rms, but for rounding errors, which open no gap; "auto" goes to double there."""
    x, y = (2 * np.pi * k * np.arange(n) / n for k in (1, 2))
    p_star, z = 1 + ulps * 2.0**-52, unit * np.cos(x)[:, None] * np.cos(y)
    found = hpc_gfmd.solve(z, p_star=p_star, accuracy=1e-3)
    assert (found.status, found.a_r, found.gap_mean) == ("converged", 1.0, 0.0)
    assert found.p_star == pytest.approx(p_star, rel=1e-15)


def test_the_area_of_all_points_in_double_precision():
    """The load that closes the gap is that of the heights as they are solved."""
    z = np.cos(np.pi / 8 * np.arange(16))[:, None] + 1e-5 * random_heights((16, 32), 3)
    assert hpc_gfmd.solve(z, a_r=1.0, physical_sizes=(6.0, 1.0)).a_r == 1


@pytest.mark.parametrize("n", [(6, 6), (1, 1), (1, 5), (7, 4)])
def test_flat(n):
    found = hpc_gfmd.solve(np.full(n, 3.0), 0.7)
    assert (found.status, found.iterations, found.a_r, found.gap_mean) == ("converged", 0, 1.0, 0.0)
    assert found.pressure == pytest.approx(np.full(n, 0.7))
    assert found.pressure.shape == n


@pytest.mark.parametrize(("n", "below"), [(127, 1e-5), (256, 3e-6), (300, 1e-3)])
def test_a_pit_in_a_plate(n, below):
    """The last open point: gap = (p_closed - p)/K_pp. "auto" goes to double where rounding errors
    of single precision hide it; what is insisted on does not claim more than it knows."""
    z = np.zeros((n, n))
    z[n // 3, n // 4] = -1.0
    closing = np.fft.ifft2(wave_numbers(z.shape) / 2 * np.fft.fft2(-z)).real.max()
    for precision in ("auto", "single"):
        found = hpc_gfmd.solve(z, closing * (1 - below), accuracy=1e-3, precision=precision)
        wrong = abs(found.gap_mean / (below / n**2) - 1)
        assert found.status == "converged" or precision == "single"
        assert wrong < found.errors[1]
        assert wrong < 1e-3 or found.status == "stagnated"
