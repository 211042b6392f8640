"""The pressure in contact against NumPy."""

import numpy as np
import pytest

from hpc_gfmd.kernels.pressure import contact_pressure


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("hardness", [None, 0.8])
@pytest.mark.parametrize("points", [37, 30])
def test_pressure_in_contact(dtype, hardness, points):
    random = np.random.default_rng(4)
    g = np.maximum(random.standard_normal((20, 37)), 0).astype(dtype)
    p = random.standard_normal(g.shape).astype(dtype)
    p[0, :3] = 0
    g[1, :2] = np.nan
    expected = np.where((g <= 0) & (p > 0), p, 0)
    if hardness is not None:
        hardness = dtype(hardness)
        g[2, :5] = -0.1  # dents
        expected[2, :5] = hardness
        expected = np.minimum(expected, hardness)
    out = np.full((20, points), np.nan, dtype)
    contact_pressure(g, p, hardness, out)
    assert np.array_equal(out, expected[:, :points])
