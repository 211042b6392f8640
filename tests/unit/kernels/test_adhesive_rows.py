"""A shift of the whole body, after which the pressure has the attraction of the new gap."""

import numpy as np
import pytest

from hpc_gfmd.kernels import adhesive_rows
from hpc_gfmd.laws import law_named
from hpc_gfmd.laws.base import in_precision

N = (7, 10)
every_edge = pytest.mark.parametrize("inside", [N, (5, 8), (0, 0)])
LAW = in_precision(law_named("exponential", 0.3, 0.5), np.dtype(float))


@pytest.fixture
def gaps(random):
    return np.maximum(random.standard_normal(N), 0)


def on_surface(inside):
    mask = np.zeros(N, bool)
    mask[: inside[0], : inside[1]] = True
    return mask


@every_edge
def test_shift(random, gaps, inside):
    g = gaps + 0.5
    w = random.standard_normal(N)
    surface = on_surface(inside)
    r = w + LAW.traction(g) * surface
    lowered_gap = g.copy()
    t = adhesive_rows.shift_gap(LAW, lowered_gap, r, 0.5, 0, N[0], inside)
    assert np.allclose(lowered_gap, g - 0.5)
    assert np.allclose(r, w + LAW.traction(lowered_gap) * surface)
    assert t == pytest.approx(np.sum(LAW.traction(lowered_gap)[surface]), abs=1e-12)
