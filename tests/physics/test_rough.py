"""Rough contacts with a known kappa = a_r/p*, with and without the edge correction."""

import numpy as np
import pytest
from contacts import rough, solve_scene, sweep_of

from hpc_gfmd import reference
from hpc_gfmd.contact import all_observables

P_STAR = 0.01 / np.sqrt(2)
CASES = [  # hurst, lam_l/lam_s, seeds, kappa, its uncertainty, edge-corrected kappa
    (0.8, 32, 12, 2.74, 0.07, 2.21),
    (0.8, 64, 6, 2.51, 0.06, 2.11),
    (0.8, 128, 3, 2.40, 0.04, 2.07),
    (0.3, 32, 8, 3.45, 0.03, 2.35),
    (0.3, 64, 4, 3.23, 0.07, 2.28),
]


def mean_and_error(contacts, *names):
    """Return the means of observables over contacts of several surfaces, and their errors."""
    values = [[all_observables()[name](contact) for name in names] for contact in contacts]
    return np.mean(values, axis=0), np.std(values, axis=0, ddof=1) / np.sqrt(len(values))


@pytest.mark.parametrize(("hurst", "ratio", "seeds", "kappa", "sigma", "corrected"), CASES)
def test_kappa(hurst, ratio, seeds, kappa, sigma, corrected):
    contacts = (
        sweep_of(rough((2, ratio, 2), hurst=hurst, seed=seed), accuracy=3e-3).solve(P_STAR)
        for seed in range(1, seeds + 1)
    )
    mean, spread = mean_and_error(contacts, "kappa", "kappa_corrected")
    error = 2 * np.hypot(sigma, spread)  # two standard errors of the difference
    assert abs(mean[0] - kappa) < error[0], (mean, spread)
    assert abs(mean[1] - corrected) < error[1], (mean, spread)
    assert error.max() < 0.2


@pytest.mark.parametrize(("hurst", "p_star"), [(0.3, 0.03), (0.8, 0.2), (0.8, 0.353553)])
def test_the_published_curve(hurst, p_star):
    """Edge-corrected areas and gaps of other surfaces on a fine grid agree with the reference
    data, which are limits of fine grids."""
    contacts = (
        solve_scene(rough((4, 16, 8), hurst=hurst, seed=seed), p_star, accuracy=1e-3)
        for seed in (101, 102, 103)
    )
    measured = mean_and_error(contacts, "a_r_corrected", "gap_over_h_rms")
    limits = reference.contact_area, reference.mean_gap
    for value, spread, limit in zip(*measured, limits, strict=True):
        expected, sigma = limit(p_star, hurst, 1 / 16)
        discretisation = 0.01 * expected  # what the edge correction leaves
        assert abs(value - expected) < 3 * np.hypot(spread, sigma) + discretisation
        assert spread < 0.03 * expected


@pytest.mark.parametrize(("p_star", "allowed_pairs"), [(0.007, 11.0), (0.353, 8.0)])
def test_pairs_do_not_grow_with_the_grid(p_star, allowed_pairs):
    """Mean FFT pairs of three surfaces for an accuracy of 1e-3 (measured at n = 512: 10.0 and 7.3).

    At p* = 0.007 a grid of 256 x 256 points takes 14, because a single point is more than 1e-3 of
    the contact area.
    """
    means = []
    for points in (128, 512):
        pairs = [
            solve_scene(rough((2, points // 4, 2), seed=seed), p_star, accuracy=1e-3).fft_pairs
            for seed in (1, 2, 3)
        ]
        means.append(np.mean(pairs))
    assert means[1] <= allowed_pairs
    assert means[1] <= means[0] + 1
