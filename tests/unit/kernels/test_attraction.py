"""Functions of single points that kernels call for an attraction, against NumPy. All laws are in
tests/contract/test_attraction_laws.py."""

import numpy as np
import pytest

from hpc_gfmd.kernels.attraction import FARTHEST, curvature_at, decay, energy_at, traction_at
from hpc_gfmd.kernels.jit import kernel
from hpc_gfmd.laws import law_named
from hpc_gfmd.laws.base import in_precision


def rounding_of(dtype):
    """Relative error of decay: some errors of a polynomial, 64-fold by the squarings."""
    return 6 * FARTHEST * float(np.finfo(dtype).eps)


@kernel
def decayed(x, out):
    for i in range(x.shape[0]):
        out[i] = decay(x[i])


@kernel
def law_at(law, g):
    return energy_at(law, g), traction_at(law, g), curvature_at(law, g)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_decay(dtype):
    """exp(-x) up to x = 64, and exp(-64) beyond."""
    x = np.concatenate([np.linspace(0, FARTHEST, 10001), [100.0, 1e30]]).astype(dtype)
    out = np.empty_like(x)
    decayed(x, out)
    wanted = np.exp(-np.minimum(x.astype(float), FARTHEST))
    assert np.allclose(out, wanted, rtol=rounding_of(dtype), atol=0)
    assert np.allclose(decay(x), np.exp(-x.astype(float)), rtol=1e-4)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_numbers_have_the_precision_of_the_gap(dtype):
    law = law_named("exponential", 0.3, 0.5)
    numbers = law_at(in_precision(law, np.dtype(dtype)), dtype(0.2))
    wanted = (law.energy(0.2), law.traction(0.2), law.curvature(0.2))
    assert numbers == pytest.approx(wanted, rel=rounding_of(dtype))
