"""Transforms and the elastic operator on slabs, against NumPy on the whole field."""

import numpy as np
import pytest
from applied import compliance_times, stiffness_times
from contacts import relative

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


def stiffness(n, sizes, u):
    qx, qy = (2 * np.pi * np.fft.fftfreq(k, L / k) for k, L in zip(n, sizes, strict=True))
    return np.fft.ifft2(np.hypot(qx[:, None], qy) / 2 * np.fft.fft2(u)).real


@pytest.mark.parametrize("n", GRIDS, ids=str)
@pytest.mark.parametrize(
    ("dtype", "tolerance"), [(np.float64, 1e-13), (np.float32, 1e-5)], ids=["double", "single"]
)
def test_stiffness(comm, n, dtype, tolerance):
    sizes = (1.0, 1.7)
    grid = Grid(n, sizes, comm)
    mine = slice(*grid.rows)
    u = np.random.default_rng(1).standard_normal(n)
    local, out = u[mine].astype(dtype), grid.empty(dtype)
    elastic = Elastic(grid, HalfSpace(), dtype)
    energy = comm.sum([stiffness_times(elastic, local, out)])[0]
    wanted = stiffness(n, sizes, u) * grid.a
    assert np.abs(out - wanted[mine]).max(initial=0) <= tolerance * max(np.abs(wanted).max(), 1e-30)
    assert energy == pytest.approx(np.vdot(u, wanted), rel=10 * tolerance, abs=1e-30)
    assert elastic.pairs == 1


@pytest.mark.parametrize("n", GRIDS, ids=str)
def test_stiffness_from_a_table(comm, n):
    """Every rank has the part of the table that belongs to its columns."""
    grid, body = Grid(n, (1.0, 1.7), comm), Layer(0.1, 0.3, "bonded")
    mine = slice(*grid.rows)
    u = np.random.default_rng(1).standard_normal(n)
    out = grid.empty(np.float64)
    energy = comm.sum([stiffness_times(Elastic(grid, body, np.float64), u[mine], out)])[0]
    alone = Grid(n, (1.0, 1.7))
    wanted = alone.empty(np.float64)
    assert energy == pytest.approx(
        stiffness_times(Elastic(alone, body, np.float64), u, wanted), rel=1e-12, abs=1e-25
    )
    assert np.abs(out - wanted[mine]).max(initial=0) <= 1e-12


@pytest.mark.parametrize("n", [(3, 16), (7, 11), (31, 37), (64, 40)], ids=str)
def test_compliance_is_the_inverse(comm, n):
    grid = Grid(n, (1.0, 1.0), comm)
    mine = slice(*grid.rows)
    p = np.random.default_rng(2).standard_normal(n)
    p -= p.mean()
    u, back = grid.empty(np.float64), grid.empty(np.float64)
    elastic = Elastic(grid, HalfSpace(), np.float64)
    compliance_times(elastic, p[mine], u)
    stiffness_times(elastic, u, back)
    if len(back) and n[0] % 2 and n[1] % 2:
        assert relative(back, p[mine]) < 1e-12
    elif len(back):
        assert np.abs(back - p[mine]).max() < 1e-12


def test_rows_of_all_ranks_make_the_grid(comm):
    for n_x in (1, 2, 3, 5, 7, 64, 101):
        grid = Grid((n_x, 4), comm=comm)
        rows = comm.allgather(grid.rows)
        assert rows[0][0] == 0
        assert rows[-1][1] == n_x
        assert all(a[1] == b[0] for a, b in zip(rows, rows[1:], strict=False))
        assert max(b - a for a, b in rows) - min(b - a for a, b in rows) <= 1


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


@pytest.mark.parametrize("rows", [1, 3])
def test_halo_rows_wrap_around(comm, rows):
    """Around a rank's own rows in one array."""
    m = 5
    starts = np.arange(comm.size + 1) * rows
    whole = np.arange(comm.size * rows * m, dtype=float).reshape(-1, m)
    windows = halo.Windows(comm.rank, starts, starts[:-1] - 1, starts[1:] + 1)
    assert windows.in_place
    a = np.zeros((rows + 2, m))
    a[1:-1] = whole[starts[comm.rank] : starts[comm.rank + 1]]
    windows.fill(comm, a[1:-1], a)
    assert np.array_equal(
        a, whole[np.arange(starts[comm.rank] - 1, starts[comm.rank + 1] + 1) % len(whole)]
    )
    ones = np.ones((1, rows + 2, m))
    windows.add(comm, ones, ones[:, 1:-1])
    assert comm.sum([ones[0, 1:-1].sum()])[0] == comm.size * (rows + 2) * m


def test_next_row_skips_ranks_without_rows(comm):
    for holes in ({0}, {comm.size - 1}, set(range(1, comm.size)), set()):
        if len(holes) < comm.size:
            rows = 0 if comm.rank in holes else 2
            after = next(
                r
                for r in [(comm.rank + 1 + k) % comm.size for k in range(comm.size)]
                if r not in holes
            )
            starts = np.cumsum([0, *(0 if rank in holes else 2 for rank in range(comm.size))])
            assert np.array_equal(
                halo.next_row(comm, np.full((3, rows, 4), comm.rank), starts),
                np.full((3, 4), after),
            )
