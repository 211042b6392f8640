"""Random waves: symmetry, band limits, uniform and independent random numbers."""

import numpy as np
import pytest

from hpc_gfmd.kernels.random_waves import random_waves
from hpc_gfmd.surface.selfaffine import NO_TABLE


def law(seed, low, high, exponent):
    """An isotropic power law on a square cell."""
    unit = np.ones(1)
    laws = (low, high, unit, unit, unit, exponent * unit)
    return (np.uint64(seed), False, 1.0, (1.0, 0.0, 1.0), laws, NO_TABLE)


def test_spectrum_of_a_real_field_within_its_band():
    n = 8
    whole = np.zeros((n, n), complex)
    for k_y in range(n):
        block = np.zeros((1, n), complex)
        signed = (k_y + 3) % n - 3
        random_waves(block, 0.0, 1.0, signed, 1, n, law(3, 1.0, 4.0, 1.8))
        whole[:, k_y] = block[0]
    heights = np.fft.ifft2(whole)
    assert np.abs(heights.imag).max() < 1e-14 * np.abs(heights.real).max()
    k = np.hypot(*np.meshgrid(np.fft.fftfreq(n, 1 / n), np.fft.fftfreq(n, 1 / n)))
    assert (np.abs(whole[(k >= 1) & (k <= 4)]) > 0).all()
    assert not whole[(k < 1) | (k > 4 + 1e-9)].any()


def test_random_numbers_are_uniform():
    """Real and imaginary parts over |k|^-(1+H) are uniform in (-1, 1).

    Neighbouring seeds and modes are independent.
    """
    parts = []
    for seed in (0, 1):
        block = np.zeros((100, 256), complex)
        random_waves(block, 0.0, 1.0, 1, 100, 512, law(seed, 1.0, 300.0, 0.0))
        block = block.T[:100]
        assert np.abs(block.real).max() < 1
        for part in (block.real.ravel(), block.imag.ravel()):
            assert np.mean(part) == pytest.approx(0, abs=0.03)
            assert np.mean(part**2) == pytest.approx(1 / 3, abs=0.02)
            parts.append(part)
    parts.append(np.roll(parts[0], 1))
    correlation = np.corrcoef(parts) - np.eye(len(parts))
    assert np.abs(correlation).max() < 0.05
