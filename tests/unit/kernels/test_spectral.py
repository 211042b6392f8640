"""Multiplications by K and sums over spectra, against NumPy."""

import numpy as np
import pytest

from hpc_gfmd.kernels import spectral

W = 3
N_X = 10
Q_X = 2 * np.pi * np.fft.fftfreq(N_X)
Q_Y = np.array([[0.1, 0.7, 1.3], [0.0, 0.4, 0.9]])  # two blocks
WEIGHT = np.array([[2.0, 2.0, 1.0], [1.0, 2.0, 0.0]])


def complex_columns(random, dtype):
    """Random complex columns of one block."""
    parts = random.standard_normal((2, W, N_X)).astype(dtype)
    return parts[0] + 1j * parts[1]


@pytest.mark.parametrize("inverse", [False, True])
@pytest.mark.parametrize("tabulated", [False, True])
@pytest.mark.parametrize("block", [0, 1])
@pytest.mark.parametrize(("dtype", "rounding"), [(np.float64, 1e-14), (np.float32, 1e-6)])
def test_multiply(random, inverse, tabulated, block, dtype, rounding):
    """Multiplication by K = |q|/2 or a table of K, and by 1/K, which is 0 where K = 0."""
    columns = complex_columns(random, dtype)
    K = np.hypot(Q_X, Q_Y[..., None]) / 2
    if tabulated:
        K = K**2 / (1 + K)
    factor = np.divide(1, K, out=np.zeros_like(K), where=K > 0) if inverse else K
    scale = 0.3
    wanted = scale * factor[block] * columns
    energy = np.sum(WEIGHT[block][:, None] * scale * factor[block] * np.abs(columns) ** 2)
    numbers = columns.view(dtype)
    table = K[..., : N_X // 2 + 1].astype(dtype) if tabulated else None
    result = spectral.multiply(
        numbers,
        block,
        inverse,
        dtype(scale),
        WEIGHT.astype(dtype),
        np.repeat(Q_X, 2).astype(dtype),
        Q_Y.astype(dtype),
        table,
    )
    assert np.allclose(columns, wanted, rtol=10 * rounding, atol=10 * rounding)
    assert result == pytest.approx(energy, rel=100 * rounding)


@pytest.mark.parametrize("dtype", [np.complex64, np.complex128])
def test_spectrum_sums(random, dtype):
    """Mean square and mean square slope of a real field without its mean, by Parseval."""
    n = (12, 9)
    h = random.standard_normal(n)
    columns = np.fft.rfft2(h).T.copy().astype(dtype) / h.size
    q_x = 2 * np.pi * np.fft.fftfreq(n[0])
    q_y = 2 * np.pi * np.arange(n[1] // 2 + 1) / n[1]
    weight = np.where(np.arange(len(q_y)) > 0, 2.0, 1.0)
    power, slopes, curvatures = spectral.spectrum_sums(columns, q_x, q_y, weight)
    assert power == pytest.approx(h.var(), rel=1e-5)
    full = np.fft.fft2(h) / h.size
    q = np.hypot(q_x[:, None], 2 * np.pi * np.fft.fftfreq(n[1]))
    assert slopes == pytest.approx(np.sum(q**2 * np.abs(full) ** 2), rel=1e-5)
    assert curvatures == pytest.approx(np.sum(q**4 * np.abs(full) ** 2), rel=1e-5)
