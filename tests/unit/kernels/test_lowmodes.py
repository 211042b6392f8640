import numpy as np
import pytest

from hpc_gfmd.kernels.lowmodes import join, multiply, split

N, MIDDLE, MODES = (16, 20), (4.5, 7.0), (5, 4)


def tables(axis):
    k = np.arange(MODES[axis] + 1)
    return k, 2 * np.pi / N[axis] * np.outer(k, np.arange(N[axis]) - MIDDLE[axis])


def parts_of(field):
    """Scalar products with the modes, by definition."""
    (k_x, x), (k_y, y) = tables(0), tables(1)
    norm = np.outer(np.where(k_x > 0, np.sqrt(2), 1), np.where(k_y > 0, np.sqrt(2), 1))
    return np.array(
        [norm * (f(x) @ field @ g(y).T) for f in (np.cos, np.sin) for g in (np.cos, np.sin)]
    )


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_there_and_back(dtype):
    field = np.random.default_rng(1).standard_normal(N).astype(dtype)
    spectrum = np.fft.rfft2(field).astype(np.result_type(dtype, np.complex64))
    (k_x, _), (k_y, _) = tables(0), tables(1)
    parts = np.empty((4, len(k_x), len(k_y)))
    shift_x, shift_y = (
        np.exp(2j * np.pi * middle / n * k) for middle, n, k in zip(MIDDLE, N, (k_x, k_y))
    )
    norm = np.outer(*(np.where(k > 0, 2.0, np.sqrt(2)) for k in (k_x, k_y))) / 2
    split(spectrum[:, : len(k_y)], shift_x, shift_y, norm, parts)
    assert np.allclose(parts, parts_of(field), atol=1e-4 if dtype == np.float32 else 1e-12)
    up, down = np.empty(norm.shape, complex), np.empty((len(k_x) - 1, len(k_y)), complex)
    join(parts, shift_x, shift_y, norm, 3.0, up, down)
    wanted = 3 * np.fft.rfft2(field)[:, : len(k_y)]
    tolerance = 1e-3 if dtype == np.float32 else 1e-11
    assert np.allclose(up, wanted[: len(k_x)], atol=tolerance)
    assert np.allclose(down, wanted[N[0] - MODES[0] :], atol=tolerance)


@pytest.mark.parametrize("how", ["all", "columns", "rows"])
def test_multiply(how):
    rng = np.random.default_rng(2)
    part = rng.standard_normal((3, 4))
    stack, m = {"all": (1, 12), "columns": (4, 3), "rows": (3, 4)}[how]
    A = rng.standard_normal((stack, m, m))
    A += A.transpose(0, 2, 1)
    x = {"all": part.reshape(1, 12), "columns": part.T, "rows": part}[how].copy()
    wanted = np.einsum("bij,bj->bi", A, x)
    assert multiply(part, A, how == "columns", np.zeros(12)) == pytest.approx(np.sum(x * wanted))
    assert np.allclose(part, wanted.T if how == "columns" else wanted.reshape(3, 4))
