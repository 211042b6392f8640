"""Flat tops of equal height all touch at light loads, which hardly deform them."""

import numpy as np
import pytest

import hpc_gfmd


@pytest.mark.parametrize("n", [64, 65, 205])
@pytest.mark.parametrize("p_star", [1e-9, 1.8e-6, 1e-5])
def test_a_checkerboard(n, p_star):
    """With an odd number of squares, equal squares are neighbours across the periodic boundary.

    The solution on a coarser grid then has 1e8 times the energy of an undeformed body: without a
    start from the latter the lightest load stagnates.
    """
    squares = np.indices((n, n)).sum(axis=0) % 2.0
    solution = hpc_gfmd.solve(
        squares, p_star=p_star, boundary="periodic", fields=("pressure", "gap")
    )
    assert solution.status == "converged"
    assert np.array_equal(solution.pressure > 0, squares == 1)
    assert solution.gap.max() == pytest.approx(1, abs=100 * p_star)
