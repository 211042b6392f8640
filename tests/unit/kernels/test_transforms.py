"""Row and column transforms of a slab against numpy.fft."""

import numpy as np
import pytest

from hpc_gfmd.kernels.transforms import load_columns, load_rows, store_columns, store_rows
from hpc_gfmd.parallel.grid import Grid

SIZES = [(8, 8), (30, 70), (9, 33), (64, 2), (2, 64), (1, 5)]
precisions = pytest.mark.parametrize(
    ("dtype", "rounding"), [(np.float64, 1e-13), (np.float32, 1e-5)]
)


def blocks_of(fft):
    """The spectra of all rows, (n_x, n_c), collected from the blocks."""
    blocks = [
        fft.blocks[fft.n_loc * j0 : fft.n_loc * j1].reshape(fft.n_loc, j1 - j0)
        for j0, j1 in zip(fft.edges, fft.edges[1:])
    ]
    return np.concatenate(blocks, axis=1)


@pytest.mark.parametrize("n", SIZES)
@precisions
def test_rows(random, n, dtype, rounding):
    """Blocks hold numpy.fft.rfft of the rows; the inverse returns n_y times the rows."""
    fft = Grid(n).fft(dtype)
    real, spectra = fft.rows[0]
    u = random.standard_normal(n).astype(dtype)
    for i0, i1 in fft.passes():
        real[: i1 - i0] = u[i0:i1]
        store_rows(spectra, i0, i1)
    assert np.allclose(blocks_of(fft), np.fft.rfft(u, axis=1), atol=10 * rounding)
    back = np.empty_like(u)
    for i0, i1 in fft.passes():
        load_rows(spectra, i0, i1)
        back[i0:i1] = real[: i1 - i0]
    assert np.allclose(back, n[1] * u, atol=100 * rounding)


@pytest.mark.parametrize("n", SIZES)
@precisions
def test_columns(random, n, dtype, rounding):
    """Columns of every block agree with numpy.fft.fft; the inverse returns them times n_x."""
    fft = Grid(n).fft(dtype)
    spectra = np.fft.rfft(random.standard_normal(n), axis=1).astype(fft.blocks.dtype)
    for j0, j1 in zip(fft.edges, fft.edges[1:]):
        fft.blocks[n[0] * j0 : n[0] * j1] = spectra[:, j0:j1].ravel()
    whole = np.fft.fft(spectra, axis=0)
    columns = fft._columns[0]
    for k, (j0, j1) in enumerate(zip(fft.edges, fft.edges[1:])):
        load_columns(columns, k)
        block = columns[0].view(fft.blocks.dtype)[: j1 - j0]
        assert np.allclose(block, whole[:, j0:j1].T, atol=100 * rounding)
        store_columns(columns, k)
    assert np.allclose(blocks_of(fft), n[0] * spectra, atol=1000 * rounding)
