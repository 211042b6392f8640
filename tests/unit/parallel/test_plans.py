"""Multiplication by K with the FFTW of each package, in several passes and threads."""

import os

import numpy as np
import pytest
from contacts import wave_numbers
from transfers import stiffness_times

from hpc_gfmd import GfmdError
from hpc_gfmd.bodies.halfspace import HALF_SPACE
from hpc_gfmd.operators.elastic import Elastic
from hpc_gfmd.parallel import fftw, wisdom
from hpc_gfmd.parallel.grid import Grid


@pytest.fixture
def fftw_of(monkeypatch):
    """fftw_of(value) loads FFTW again, with a value of HPC_GFMD_FFTW."""

    def load(value):
        monkeypatch.setenv(fftw.VARIABLE, value)
        fftw.load_fftw.cache_clear()
        wisdom._wisdom.cache_clear()
        return fftw.load_fftw()

    yield load
    fftw.load_fftw.cache_clear()
    wisdom._wisdom.cache_clear()


@pytest.mark.parametrize("package", fftw.PACKAGES)
@pytest.mark.parametrize(("dtype", "rounding"), [(np.float64, 1e-13), (np.float32, 1e-5)])
@pytest.mark.parametrize("threads", [1, 3])
def test_stiffness_in_several_passes(fftw_of, package, dtype, rounding, threads):
    files = fftw._files_of(package, fftw.PACKAGES[package])
    if not files:
        pytest.skip(f"{package} is missing")
    assert fftw_of(os.pathsep.join(files))[1].keys() == {"float32", "float64"}
    grid = Grid((612, 1030), threads=threads)
    u = np.random.default_rng(1).standard_normal(grid.n).astype(dtype)
    wanted = np.fft.ifft2(wave_numbers(grid.n) * grid.a / 2 * np.fft.fft2(u)).real
    Ku = np.empty_like(u)
    elastic = Elastic(grid, HALF_SPACE, dtype)
    stiffness_times(elastic, u, Ku)
    assert np.abs(Ku - wanted).max() < rounding * np.abs(wanted).max()


@pytest.mark.parametrize("value", ["libm.so.6", "no such file"])
def test_a_library_without_fftw_is_refused(fftw_of, value):
    with pytest.raises(GfmdError, match=f"HPC_GFMD_FFTW.*{value}"):
        fftw_of(value)
