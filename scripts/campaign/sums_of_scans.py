"""The family of sums of two scans with unlike points, sizes and places, which are waves.

A sum that differs from the sum of the waves is an error of the wall, and has no rows.
"""

import numpy as np

import hpc_gfmd

from .registry import family, single
from .shapes import choice

COARSE_ERROR = 0.02  # of cubic splines on at least 12 points a wave, over the sum's range
ROUNDED = 1e-9
SHORTEST = 12  # points a wave


@family
def sum_of_scans(rng):
    p, q = (int(k) for k in rng.integers(1, 13, 2))
    spacings = np.array([p, q]) / max(p, q)
    counts = [rng.integers(14, 60, 2) for _ in range(2)]
    at = choice(rng, (0.0, 1.0, float(rng.uniform(0, 2)))) * spacings.max()
    waves = 2 * np.pi / spacings.max() / rng.uniform(SHORTEST, 40, (2, 2, 2))
    phases = rng.uniform(0, 2 * np.pi, (2, 2, 2))

    def heights(body, x, y):
        """Return a sum of two waves along each axis."""
        along = [
            np.cos(np.multiply.outer(axis, waves[body, k]) + phases[body, k]).sum(-1)
            for k, axis in enumerate((x, y))
        ]
        return np.add.outer(*along)

    scans = []
    for body, (spacing, n) in enumerate(zip(spacings, counts)):
        x, y = (spacing * np.arange(k) for k in n)
        sizes = tuple(float(spacing * k) for k in n)
        scans.append(
            hpc_gfmd.prepare_surface(heights(body, x, y), physical_sizes=sizes, boundary="free")
        )
    both = hpc_gfmd.combine_surfaces(*scans, mirrored="none", shift=(at, at))
    z = np.asarray(both.heights, float)
    spacing = both.sizes[0] / z.shape[0]
    # points are those of the finer scan, from the first one that both have
    start = at if q < p else spacing * np.ceil(at / spacing - ROUNDED)
    x, y = (start + spacing * np.arange(k) for k in z.shape)
    expected = heights(0, x, y) + heights(1, x - at, y - at)
    error = np.ptp(z - expected) / np.ptp(expected)
    assert error < COARSE_ERROR, f"the sum of the scans is off by {error:.2g} of its height"
    return single(rng, z, both.sizes, 1e-2, 0.3, free=(True, True), units=False)
