"""Kernels of the certificate and of cheap observables against NumPy."""

import numpy as np
import pytest
from sides import sides

from hpc_gfmd.kernels import certify


@pytest.mark.parametrize("hardness", [None, 0.4])
def test_kkt_residuals(random, hardness):
    g = random.standard_normal((6, 5))
    g[np.abs(g) < 0.3] = 0
    x = random.standard_normal((6, 5))
    p = np.empty((6, 5))
    sums, tension = certify.kkt_residuals(g, p, x, 0.2, hardness, g.shape, 0, 6, np.zeros(5))
    fresh = 0.2 + x
    closed, yields, r = sides(g, fresh, hardness)
    gap = np.where(yields, 0, g)
    wanted = (
        *(np.sum(r[~closed] ** power) for power in (1, 2, 4)),
        np.sum(fresh[closed] ** 2) + np.sum(yields) * (hardness or 0) ** 2,
        np.sum(np.abs(r) * np.where(yields, -g, g)),
        np.sum(closed | yields),
        gap.sum(),
        yields.sum(),
    )
    assert np.array_equal(p, fresh)
    assert sums == pytest.approx(wanted, rel=1e-13)
    assert tension == pytest.approx(max((-fresh[g <= 0]).max(initial=0), 0), rel=1e-13)
    moments = certify.open_moments(g, p, hardness, g.shape)
    assert moments == pytest.approx(wanted[1:3], rel=1e-13)


def test_uncertain_points(random):
    g = np.maximum(random.standard_normal((40, 50)), 0)
    p = random.standard_normal((40, 50))
    distance = np.where(g > 0, g / 0.7, np.abs(p))
    contact = (g <= 0) & (p > 0)
    tied = distance < 0.05
    distance = np.where(g > 0, np.maximum(distance - np.maximum(p, 0), 0), distance) ** 2
    counts = np.zeros((2, certify.BINS))
    certify.count_uncertain(g, p, g.shape, 0.7, 0.05, 0.1, 0.5, 0.0, counts)
    edges = 0.5 * 2.0 ** (-np.arange(certify.BINS + 1) / certify.PER_OCTAVE)
    for side, counted in zip((contact, ~contact), counts, strict=True):
        distances_of_side = distance[side & ~tied & (distance <= 0.5)]
        binned = distances_of_side[distances_of_side > 0.1**2]
        assert counted[-1] == np.sum(distances_of_side <= 0.1**2) > 0
        wanted = [np.sum((binned > low) & (binned <= high)) for high, low in zip(edges, edges[1:])]
        assert np.array_equal(counted[:-1], wanted[:-1])


@pytest.mark.parametrize(("easy", "hard"), [(9.0, 16.0), (16.0, 9.0)])
def test_points_that_are_expected_to_change(easy, hard):
    """Of those within twice the rms error the half with more, or all, and the root of it."""
    takes = 8 * 2.0 ** -np.arange(certify.BINS)
    points = np.zeros(certify.BINS)
    points[[1, 2, 4]] = 100.0, hard, easy  # out of reach, beyond half of the reach, within it
    for all_change, expected in ((False, 16 + 4), (True, 25 + 5)):
        changing = certify.changing_points(points, takes, 1.0, 0.0, 1e9, 2.0, 3.0, all_change)
        assert changing == expected
