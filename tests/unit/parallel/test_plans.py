"""Transforms that kernels call, by either library."""

import numpy as np
import pytest
from transfers import stiffness_times

from hpc_gfmd.bodies.halfspace import HALF_SPACE
from hpc_gfmd.operators.elastic import Elastic
from hpc_gfmd.parallel import plans
from hpc_gfmd.parallel.grid import Grid


@pytest.mark.parametrize("library", ["FFTW, where it is installed", "scipy.fft"])
@pytest.mark.parametrize(("dtype", "rounding"), [(np.float64, 1e-13), (np.float32, 1e-5)])
@pytest.mark.parametrize("threads", [1, 3])
def test_against_numpy(monkeypatch, library, dtype, rounding, threads):
    """K u of several passes of rows and blocks of columns."""
    if library == "scipy.fft":
        monkeypatch.setattr(plans, "load_fftw", lambda: None)
    grid = Grid((612, 1030), threads=threads)
    u = np.random.default_rng(1).standard_normal(grid.n).astype(dtype)
    q = np.hypot(grid.q_x[:, None], grid.q_y)
    wanted = np.fft.irfft2(q / 2 * np.fft.rfft2(u.astype(float)), grid.n)
    found = np.empty_like(u)
    elastic = Elastic(grid, HALF_SPACE, dtype)
    assert min(len(elastic.fft.passes()), elastic.fft.K) > 3
    energy = stiffness_times(elastic, u, found)
    assert np.abs(found - wanted).max() < rounding * np.abs(wanted).max()
    assert energy == pytest.approx(np.vdot(u.astype(float), wanted), rel=10 * rounding)
