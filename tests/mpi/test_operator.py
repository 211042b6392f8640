"""Transforms and the elastic operator on slabs against those of the whole field on one rank."""

import numpy as np
import pytest
from transfers import SIZES, assert_same_on_slabs

from hpc_gfmd.bodies.halfspace import HALF_SPACE
from hpc_gfmd.bodies.layer import Layer
from hpc_gfmd.operators.elastic import reader
from hpc_gfmd.parallel import halo
from hpc_gfmd.parallel.grid import Grid

pytestmark = pytest.mark.mpi

# Thin grids (ranks without rows), grids of few columns (ranks without columns), odd, prime and
# rectangular ones, and some of more than one pass.
GRIDS = [*SIZES, (31, 37), (64, 40), (200, 301)]


@pytest.mark.parametrize("n", GRIDS)
@pytest.mark.parametrize(("dtype", "tolerance"), [(np.float64, 1e-13), (np.float32, 1e-5)])
@pytest.mark.parametrize("body", [HALF_SPACE, Layer(0.1, 0.3, "bonded")], ids=["", "by a table"])
def test_stiffness_and_compliance(comm, n, dtype, tolerance, body):
    """physics/test_oracle.py compares the values on one rank with dense linear algebra."""
    assert_same_on_slabs(comm, n, dtype, tolerance, body)


@pytest.mark.parametrize("n", [(7, 11), (31, 37), (200, 301)])
@pytest.mark.parametrize(("dtype", "tolerance"), [(np.float64, 1e-13), (np.float32, 1e-5)])
def test_spectrum_is_that_of_mpi4py_fft(comm, n, dtype, tolerance):
    MPI = pytest.importorskip("mpi4py.MPI")
    PFFT = pytest.importorskip("mpi4py_fft").PFFT
    u = np.random.default_rng(2).standard_normal(n).astype(dtype)
    pfft = PFFT(comm.mpi or MPI.COMM_SELF, n, dtype=dtype)
    parts = comm.allgather((pfft.local_slice(True), pfft.forward(u[pfft.local_slice(False)])))
    wanted = np.empty((n[0], n[1] // 2 + 1), complex)
    for place, part in parts:
        wanted[place] = part
    grid = Grid(n, comm=comm)
    fft = grid.fft(dtype)
    fft.forward_rows(reader(u[slice(*grid.rows)]))
    blocks = fft.columns(lambda block, m: (fft.columns_of(m), block.T * fft.scale), backward=False)
    for (j0, j1), block in blocks:
        assert np.abs(block - wanted[:, j0:j1]).max() < tolerance


@pytest.mark.parametrize(("n", "lost"), [(1, 0), (2, 0), (7, 0), (24, 0), (24, 5)])
@pytest.mark.parametrize("case", range(4))
def test_windows(comm, n, lost, case):
    """`rows_of` returns any rows of a ring from the ranks that own them, and `add` is its
    transpose; the last `lost` rows have no owner and are zero."""
    random = np.random.default_rng(case)
    starts = np.append(0, np.sort(random.integers(0, n - lost + 1, comm.size)))
    starts[-1] = n - lost
    lo = random.integers(-4, n, comm.size)
    hi = lo + random.integers(0, n + 6, comm.size)
    whole = random.standard_normal((2, n, 3))
    whole[:, n - lost :] = 0
    mine = slice(starts[comm.rank], starts[comm.rank + 1])
    window = halo.rows_of(comm, whole[:, mine], starts, lo, hi, n)
    taken = np.arange(lo[comm.rank], hi[comm.rank]) % n
    assert np.array_equal(window, whole[:, taken])
    total = np.zeros((2, n, 3))
    for rank in range(comm.size):
        for i in range(lo[rank], hi[rank]):
            total[:, i % n] += rank + 1
    owned = np.zeros_like(whole[:, mine])
    halo.Windows(comm.rank, starts, lo, hi, n).add(comm, np.full_like(window, comm.rank + 1), owned)
    assert np.array_equal(owned, total[:, mine])
