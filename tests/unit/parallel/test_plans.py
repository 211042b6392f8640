"""Multiplication by K with FFTW and with its replacement, in several passes and threads."""

import numpy as np
import pytest
from contacts import wave_numbers
from transfers import stiffness_times

from hpc_gfmd.bodies.halfspace import HALF_SPACE
from hpc_gfmd.operators.elastic import Elastic
from hpc_gfmd.parallel import plans
from hpc_gfmd.parallel.grid import Grid


@pytest.mark.parametrize("library", [plans.load_fftw, lambda: None])
@pytest.mark.parametrize(("dtype", "rounding"), [(np.float64, 1e-13), (np.float32, 1e-5)])
@pytest.mark.parametrize("threads", [1, 3])
def test_stiffness_in_several_passes(monkeypatch, library, dtype, rounding, threads):
    monkeypatch.setattr(plans, "load_fftw", library)
    grid = Grid((612, 1030), threads=threads)
    u = np.random.default_rng(1).standard_normal(grid.n).astype(dtype)
    wanted = np.fft.ifft2(wave_numbers(grid.n) * grid.a / 2 * np.fft.fft2(u)).real
    Ku = np.empty_like(u)
    elastic = Elastic(grid, HALF_SPACE, dtype)
    stiffness_times(elastic, u, Ku)
    assert np.abs(Ku - wanted).max() < rounding * np.abs(wanted).max()
