"""Rough contacts whose kappa = a_r/p* is known: H, lam_l/lam_s, with and without the edge correction."""

import numpy as np
import pytest
from contacts import rough, sweep_of

from hpc_gfmd.registry import all_observables

P_STAR = 0.01 / np.sqrt(2)
CASES = [  # hurst, lam_l/lam_s, seeds, kappa, its uncertainty, edge-corrected kappa
    (0.8, 32, 12, 2.74, 0.07, 2.21),
    (0.8, 64, 6, 2.51, 0.06, 2.11),
    (0.8, 128, 3, 2.40, 0.04, 2.07),
    (0.3, 32, 8, 3.45, 0.03, 2.35),
    (0.3, 64, 4, 3.23, 0.07, 2.28),
]


@pytest.mark.parametrize(("hurst", "ratio", "seeds", "kappa", "sigma", "corrected"), CASES)
def test_kappa(hurst, ratio, seeds, kappa, sigma, corrected):
    found = []
    for seed in range(1, seeds + 1):
        sweep = sweep_of(rough((2, ratio, 2), hurst=hurst, seed=seed), accuracy=3e-3)
        contact = sweep.solve(P_STAR).contact
        found.append([all_observables()[name](contact) for name in ("kappa", "kappa_corrected")])
    mean, spread = np.mean(found, axis=0), np.std(found, axis=0, ddof=1) / np.sqrt(seeds)
    assert abs(mean[0] - kappa) < 2 * sigma + 2 * spread[0], (mean, spread)
    assert abs(mean[1] - corrected) < 2 * sigma + 2 * spread[1], (mean, spread)
    assert mean[1] < mean[0]


def test_persson_at_high_load():
    """At p* = 0.353553 theory has a_r = erf(1/2) = 0.5205; simulations are at 0.57 to 0.69."""
    contact = sweep_of(rough((2, 32, 2))).solve(0.5 / np.sqrt(2)).contact
    assert 0.57 < all_observables()["a_r"](contact) < 0.72
    assert all_observables()["gap_over_h_rms"](contact) < 0.1
