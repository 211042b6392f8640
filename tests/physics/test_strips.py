"""Surfaces of a few points across: the long axis alone has coarser grids."""

import numpy as np
import pytest
from campaign.truth import Contact

import hpc_gfmd


@pytest.mark.parametrize(
    ("n", "p_star"), [((3, 3000), 0.02), ((3000, 2), 0.02), ((4, 20000), 1e-3), ((2, 50000), 1e-3)]
)
def test_a_long_strip(n, p_star):
    """Random walks along the strip, an independent one in each line: few pairs to the solution. At
    the small load the start from coarse grids has much energy, and is better than none all the
    same."""
    random, along = np.random.default_rng(0), int(np.argmax(n))
    z = np.cumsum(random.standard_normal(n), axis=along)
    z = z - np.linspace(np.zeros(min(n)), np.take(z, -1, along), max(n), axis=along)
    truth = Contact(z, np.divide(n, min(n)))
    exact = truth.solve(p_star)
    found = hpc_gfmd.solve(z, p_star * truth.g_rms, physical_sizes=tuple(np.divide(n, min(n))))
    assert found.status == "converged"
    assert found.fft_pairs < 40
    wrong = exact.errors(
        round(found.a_r * z.size), found.gap_mean / truth.height_unit, found.pressure / truth.g_rms
    )
    assert max(wrong) < 1e-3
