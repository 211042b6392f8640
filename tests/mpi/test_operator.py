"""Transforms and the elastic operator on slabs, against NumPy on the whole field."""

import numpy as np
import pytest
from transfers import compliance_times, stiffness_times

from hpc_gfmd.bodies.halfspace import HalfSpace
from hpc_gfmd.bodies.layer import Layer
from hpc_gfmd.operators.elastic import Elastic
from hpc_gfmd.parallel import halo
from hpc_gfmd.parallel.grid import Grid

pytestmark = pytest.mark.mpi

# thin (ranks without rows), few columns (ranks without columns), odd, prime, rectangular, more than
# one pass
GRIDS = [
    (1, 1),
    (1, 8),
    (8, 1),
    (3, 16),
    (5, 12),
    (7, 11),
    (13, 1),
    (16, 2),
    (31, 37),
    (40, 64),
    (64, 40),
    (200, 301),
]


@pytest.mark.parametrize("n", GRIDS, ids=str)
@pytest.mark.parametrize(
    ("dtype", "tolerance"), [(np.float64, 1e-13), (np.float32, 1e-5)], ids=["double", "single"]
)
@pytest.mark.parametrize("body", [HalfSpace(), Layer(0.1, 0.3, "bonded")], ids=["", "by a table"])
def test_stiffness_and_compliance(comm, n, dtype, tolerance, body):
    """Of which physics/test_elastic.py has the numbers on one rank."""
    whole, grid = Grid(n, (1.0, 1.7)), Grid(n, (1.0, 1.7), comm)
    mine, u = slice(*grid.rows), np.random.default_rng(1).standard_normal(n).astype(dtype)
    for apply in (stiffness_times, compliance_times):
        wanted, out = whole.empty(dtype), grid.empty(dtype)
        energy = apply(Elastic(whole, body, dtype), u, wanted)
        elastic = Elastic(grid, body, dtype)
        found = comm.sum([apply(elastic, u[mine], out)])[0]
        assert found == pytest.approx(energy, rel=10 * tolerance, abs=1e-25)
        least = tolerance * max(np.abs(wanted).max(), 1e-20)
        assert np.abs(out - wanted[mine]).max(initial=0) <= least
        assert elastic.pairs == 1


@pytest.mark.parametrize(("n", "lost"), [(1, 0), (2, 0), (7, 0), (24, 0), (24, 5)])
@pytest.mark.parametrize("case", range(4))
def test_windows(comm, n, lost, case):
    """Any rows of a ring, owned by any ranks or (the last ones) by nobody: `fill` takes them, `add`
    is its transpose."""
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
