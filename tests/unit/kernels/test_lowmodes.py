"""The lowest modes of a field against their integrals in NumPy."""

import numpy as np
import pytest

from hpc_gfmd.kernels import lowmodes

N = (16, 12)
M = (4, 3)
MIDDLE = (5.5, 4.0)  # of the surface, in grid points
NORM = np.outer(*(np.where(np.arange(m) > 0, 2.0, np.sqrt(2)) for m in M)) / 2
SHIFTS = [np.exp(2j * np.pi * middle / n * np.arange(m)) for middle, n, m in zip(MIDDLE, N, M)]


def products(k, j):
    """Orthonormal products cos cos, cos sin, sin cos, sin sin of a mode about the middle."""
    x, y = (2 * np.pi * w / n * (np.arange(n) - m) for w, n, m in zip((k, j), N, MIDDLE))
    return [
        NORM[k, j] * 2 * np.outer(f(x), g(y)) for f in (np.cos, np.sin) for g in (np.cos, np.sin)
    ]


def test_split_gives_integrals_over_the_cell(random):
    u = random.standard_normal(N)
    parts = np.zeros((4, *M))
    lowmodes.split(np.fft.fft2(u)[:, : M[1]].copy(), *SHIFTS, NORM, parts)
    for k in range(M[0]):
        for j in range(M[1]):
            wanted = [np.vdot(product, u) / 2 for product in products(k, j)]
            assert parts[:, k, j] == pytest.approx(wanted, abs=1e-12)


def test_join_undoes_split(random):
    waves = np.fft.fft2(random.standard_normal(N))[:, : M[1]].copy()
    parts = np.zeros((4, *M))
    lowmodes.split(waves, *SHIFTS, NORM, parts)
    positive = np.zeros(M, complex)
    negative = np.zeros((M[0] - 1, M[1]), complex)
    lowmodes.join(parts, *SHIFTS, NORM, 3.0, positive, negative)
    assert positive == pytest.approx(3 * waves[: M[0]], abs=1e-12)
    assert negative == pytest.approx(3 * waves[N[0] - M[0] + 1 :], abs=1e-12)


@pytest.mark.parametrize("by_columns", [False, True])
def test_multiply_by_a_stack(random, by_columns):
    rows = 4
    columns = 3
    stack, m = (columns, rows) if by_columns else (rows, columns)
    matrices = random.standard_normal((stack, m, m))
    matrices += matrices.transpose(0, 2, 1)
    part = random.standard_normal((rows, columns))
    vectors = part.T.copy() if by_columns else part.copy()
    wanted = np.einsum("bij,bj->bi", matrices, vectors)
    product = lowmodes.multiply(part, matrices, by_columns, np.zeros(m))
    assert np.allclose(part, wanted.T if by_columns else wanted)
    assert product == pytest.approx(np.sum(vectors * wanted))


def test_multiply_all_modes_by_one_matrix(random):
    part = random.standard_normal((4, 3))
    matrix = random.standard_normal((12, 12))
    matrix += matrix.T
    wanted = (matrix @ part.ravel()).reshape(4, 3)
    energy = part.ravel() @ matrix @ part.ravel()
    assert lowmodes.multiply(part, matrix[None], False, np.zeros(12)) == pytest.approx(energy)
    assert np.allclose(part, wanted)
