"""The equations of the film over missing heights against NumPy."""

import numpy as np
import pytest

from hpc_gfmd.kernels import film


def test_equations_of_a_film(random):
    z = random.standard_normal((3, 4))
    runs = np.array([[0, 0, 2], [1, 3, 4], [2, 1, 4]], np.int32)
    missing = np.array([[1, 1, 0, 0], [0, 0, 0, 1], [0, 1, 1, 1]], bool)
    direction, right = random.standard_normal((2, 6)).astype(np.float32)
    moved = z.copy()
    moved[missing] += 0.5 * direction
    largest = film.move(z, runs, direction, 0.5, 2.0, right)
    assert np.allclose(z, moved, rtol=1e-14)
    edged = np.pad(z, 1, "edge")
    around = edged[:-2, 1:-1] + edged[2:, 1:-1] + edged[1:-1, :-2] + edged[1:-1, 2:]
    lacking = ((around - 4 * z) / 2)[missing]
    assert np.allclose(right, lacking, rtol=1e-6)
    assert largest == pytest.approx(np.abs(lacking).max())
    heights = np.where(missing, z, 0).astype(np.float32)
    wanted = heights[missing] + 0.25 * direction
    curvature = film.turn(direction, 0.25, heights, runs)
    assert np.allclose(heights[missing], wanted)
    assert np.array_equal(heights[missing], direction)
    edged = np.pad(heights.astype(float), 1, "edge")
    around = edged[:-2, 1:-1] + edged[2:, 1:-1] + edged[1:-1, :-2] + edged[1:-1, 2:]
    assert curvature == pytest.approx(np.sum(heights * (4 * heights - around)), rel=1e-5)
