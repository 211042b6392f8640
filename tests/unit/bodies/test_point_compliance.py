"""The displacement by a pressure on the same point agrees with the sum over all modes."""

import numpy as np
import pytest

from hpc_gfmd.bodies.halfspace import HALF_SPACE
from hpc_gfmd.bodies.layer import Layer
from hpc_gfmd.parallel.grid import Grid


@pytest.mark.parametrize("body", [HALF_SPACE, Layer(thickness=0.1, nu=0.3, base="bonded")])
@pytest.mark.parametrize("n", [(16, 16), (200, 100), (1, 300)])
def test_point_compliance(body, n):
    grid = Grid(n, (1.0, n[1] / n[0] if n[0] > 1 else 1.0))
    q_x, q_y = (2 * np.pi * np.fft.fftfreq(k) * grid.a / s for k, s in zip(n, grid.spacings))
    q = np.hypot(q_x[:, None], q_y).ravel()[1:]
    exact = np.sum(1 / body.stiffness(q, grid.a)) / np.prod(n)
    assert body.point_compliance(grid) == pytest.approx(exact, rel=0.02)
