"""Kernels on spectra against what they mean, written down once more in NumPy."""

import numpy as np
import pytest

from hpc_gfmd.kernels import spectral
from hpc_gfmd.util.aligned import zeros_aligned


@pytest.mark.parametrize("edges", [[0, 4, 8, 12, 13], [0, 13], [0, 5, 9, 13, 13]], ids=str)
def test_blocks(random, edges):
    rows = random.standard_normal((3, 13)) + 1j
    edges, blocks, back = np.array(edges), np.zeros(7 * 13, complex), np.zeros((3, 13), complex)
    spectral.to_blocks(rows, blocks, edges, 7, 2, 3)
    whole = np.concatenate(
        [blocks[7 * a : 7 * b].reshape(7, b - a) for a, b in zip(edges, edges[1:])], axis=1
    )
    assert np.array_equal(whole[2:5], rows)
    assert not whole[:2].any()
    assert not whole[5:].any()
    spectral.from_blocks(blocks, back, edges, 7, 2, 3)
    assert np.array_equal(back, rows)


@pytest.mark.parametrize("dtype", [np.complex64, complex])
@pytest.mark.parametrize("offset", [0, 1])
def test_large_blocks(random, dtype, offset):
    """Whole cache lines of a spectrum that no cache holds are streamed, where the memory and the
    width of a block allow it."""
    edges, n_loc = np.array([0, 16, 32, 35, 83, 87]), 8192
    rows = (random.standard_normal((3, 87)) + 1j * random.standard_normal((3, 87))).astype(dtype)
    blocks, back = (
        zeros_aligned((n_loc * 87 + 8,), dtype)[offset : offset + n_loc * 87],
        np.zeros((3, 87), dtype),
    )
    assert blocks.nbytes > spectral.STREAMED
    spectral.to_blocks(rows, blocks, edges, n_loc, 5, 3)
    for a, b in zip(edges, edges[1:]):
        block = blocks[n_loc * a : n_loc * b].reshape(n_loc, b - a)
        assert np.array_equal(block[5:8], rows[:, a:b])
        assert not block[:5].any()
        assert not block[8:].any()
    spectral.from_blocks(blocks, back, edges, n_loc, 5, 3)
    assert np.array_equal(back, rows)


@pytest.mark.parametrize(
    "cuts",
    [[0, 24], [0, 9, 9, 24], [8, 16, 0, 8, 16, 24]],
    ids=["whole", "ranks", "in another order"],
)
@pytest.mark.parametrize("width", [8, 5, 1])
def test_transpose(random, width, cuts):
    """Of a block whose rows are in pieces, somewhere in memory."""
    block, columns = random.standard_normal((24, width)), np.empty((width, 24))
    rows = np.array(list(zip(cuts, cuts[1:])) if cuts[0] == 0 else np.reshape(cuts, (-1, 2)))
    first = 3 + 2 * np.arange(len(rows)) + np.cumsum([0, *np.diff(rows)[:-1, 0]]) * width
    memory, back = np.full(200, np.nan), np.full(200, np.nan)
    for start, (i0, i1) in zip(first, rows, strict=True):
        memory[start : start + (i1 - i0) * width] = block[i0:i1].ravel()
    spectral.transpose(memory, first, rows, columns)
    assert np.array_equal(columns, block.T)
    spectral.transpose_back(columns, back, first, rows)
    assert np.array_equal(back, memory, equal_nan=True)


@pytest.mark.parametrize(
    ("kernel", "power"), [(spectral.multiply_stiffness, 1), (spectral.multiply_compliance, -1)]
)
def test_multiply(random, kernel, power):
    n_x = 5 + spectral.PIECE  # more than is summed up at once
    q_x, q_y, weight = (
        np.repeat(random.standard_normal(n_x), 2),
        random.standard_normal(4),
        np.array([1.0, 2, 2, 0]),
    )
    q_x[:2] = q_y[0] = 0
    block = random.standard_normal((4, 2 * n_x))
    q = np.hypot(q_x, q_y[:, None])
    k = 0.3 * np.power(q, power, out=np.zeros_like(q), where=q > 0)
    before = block.copy()
    energy = kernel(block, q_x, q_y, weight, 0.3)
    assert energy == pytest.approx(np.sum(weight[:, None] * k * before**2), rel=1e-13)
    assert np.allclose(block, k * before, rtol=1e-14)


def test_spectrum_sums(random):
    q_x, q_y, weight = np.array([0, 1.0, -1]), np.array([0, 2.0]), np.array([1.0, 2])
    block = random.standard_normal((2, 3)) + 1j * random.standard_normal((2, 3))
    q2 = q_x**2 + q_y[:, None] ** 2
    power = weight[:, None] * np.abs(block) ** 2
    assert spectral.spectrum_sums(block, q_x, q_y, weight) == pytest.approx(
        (power[q2 > 0].sum(), (q2 * power).sum())
    )
