"""Surfaces a few points wide, whose coarser grids differ along the long axis only."""

import numpy as np
import pytest
from campaign.truth import Contact

import hpc_gfmd


@pytest.mark.parametrize(
    ("n", "p_star"),
    [
        pytest.param((3, 3000), 0.02, marks=pytest.mark.quick),
        pytest.param((3000, 2), 0.02, marks=pytest.mark.quick),
        ((4, 8000), 1e-3),
        ((2, 20000), 1e-3),
    ],
)
def test_a_long_strip(n, p_star):
    """An independent random walk in each line takes few FFT pairs.

    At the small load the start from coarse grids has a high energy but still saves iterations.
    """
    random = np.random.default_rng(0)
    along = int(np.argmax(n))
    z = np.cumsum(random.standard_normal(n), axis=along)
    z = z - np.linspace(np.zeros(min(n)), np.take(z, -1, along), max(n), axis=along)
    exact_contact = Contact(z, np.divide(n, min(n)))
    exact = exact_contact.solve(p_star)
    solution = hpc_gfmd.solve(
        z, p_star * exact_contact.g_rms, physical_sizes=tuple(np.divide(n, min(n)))
    )
    assert solution.status == "converged"
    assert solution.fft_pairs < 40
    errors = exact.errors(
        round(solution.a_r * z.size),
        solution.gap_mean / exact_contact.height_unit,
        solution.pressure / exact_contact.g_rms,
    )
    assert max(errors) < 1e-3
