"""Walls made of Fourier modes are the same on any number of ranks."""

import numpy as np
import pytest
from contacts import random_heights
from mpi.same import save

from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.scene import Scene
from hpc_gfmd.surface import build_surface

pytestmark = pytest.mark.mpi
SPECTRUM = {"kind": "spectrum", "n": [36, 20], "physical_sizes": [2.0, 1.0], "seed": 5}
WALLS = {
    "heights": {"q": [6.3, 25.0], "C": [1e-3, 1e-6], "dimension": 2, "skewness": -0.5},
    "anisotropic": {"q": [3.2, 25.0], "C": [1e-3, 1e-8], "dimension": 2, "peklenik": 3.0},
    "power laws": {"wavelengths": [2.0, 1.0, 0.2], "hurst": [-1.0, 0.5], "g_rms": 0.3},
}


def surface(keys, comm):
    scene = Scene.from_dict({"surface": SPECTRUM | keys, "load": {"pressure": 1.0}})
    return build_surface(scene.surface, comm, np.float64)


@pytest.mark.parametrize("name", WALLS)
def test_same_wall_on_any_number_of_ranks(comm, name):
    whole = surface(WALLS[name], SerialComm())
    made = surface(WALLS[name], comm)
    assert made.h == pytest.approx(whole.h[slice(*made.rows)], abs=1e-12)
    assert (made.h_rms, made.g_rms) == pytest.approx((whole.h_rms, whole.g_rms), rel=1e-12)


def test_wall_of_coefficients_is_the_map_on_any_number_of_ranks(comm):
    z = random_heights((15, 8))
    save(comm, c=np.fft.fft2(z) / z.size)
    spec = {"kind": "fourier", "path": "c.npy", "n": [15, 8]}
    made = build_surface(
        Scene.from_dict({"surface": spec, "load": {"pressure": 1.0}}).surface, comm, np.float64
    )
    gap = (z.max() - z)[slice(*made.rows)]
    assert made.h * made.height_unit == pytest.approx(gap, abs=1e-13)
