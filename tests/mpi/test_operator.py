"""Transforms and the elastic operator on slabs, against NumPy on the whole field."""

import numpy as np
import pytest
from contacts import relative

from hpc_gfmd.bodies.halfspace import HalfSpace
from hpc_gfmd.bodies.layer import Layer
from hpc_gfmd.grid import Grid
from hpc_gfmd.operators.elastic import Elastic
from hpc_gfmd.parallel import halo

pytestmark = pytest.mark.mpi

# thin (ranks without rows), few columns (ranks without columns), odd, prime, rectangular, more than one pass
GRIDS = [(1, 1), (1, 8), (8, 1), (3, 16), (5, 12), (7, 11), (13, 1), (16, 2), (31, 37), (40, 64), (64, 40), (200, 301)]


def stiffness(n, sizes, u):
    qx, qy = (2 * np.pi * np.fft.fftfreq(k, L / k) for k, L in zip(n, sizes, strict=True))
    return np.fft.ifft2(np.hypot(qx[:, None], qy) / 2 * np.fft.fft2(u)).real


@pytest.mark.parametrize("n", GRIDS, ids=str)
@pytest.mark.parametrize(("dtype", "tolerance"), [(np.float64, 1e-13), (np.float32, 1e-5)], ids=["double", "single"])
def test_stiffness(comm, n, dtype, tolerance):
    sizes = (1.0, 1.7)
    grid = Grid(n, sizes, comm)
    mine = slice(*grid.rows)
    u = np.random.default_rng(1).standard_normal(n)
    local, out = u[mine].astype(dtype), grid.empty(dtype)
    elastic = Elastic(grid, HalfSpace(), dtype)
    energy = comm.sum([elastic.apply_to(local, out)])[0]
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
    energy = comm.sum([Elastic(grid, body, np.float64).apply_to(u[mine], out)])[0]
    alone = Grid(n, (1.0, 1.7))
    wanted = alone.empty(np.float64)
    assert energy == pytest.approx(Elastic(alone, body, np.float64).apply_to(u, wanted), rel=1e-12, abs=1e-25)
    assert np.abs(out - wanted[mine]).max(initial=0) <= 1e-12


@pytest.mark.parametrize("n", [(3, 16), (7, 11), (31, 37), (64, 40)], ids=str)
def test_compliance_is_the_inverse(comm, n):
    grid = Grid(n, (1.0, 1.0), comm)
    mine = slice(*grid.rows)
    p = np.random.default_rng(2).standard_normal(n)
    p -= p.mean()
    u, back = grid.empty(np.float64), grid.empty(np.float64)
    elastic = Elastic(grid, HalfSpace(), np.float64)
    elastic.apply_compliance(p[mine], u)
    elastic.apply_to(u, back)
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


def test_halo_rows_wrap_around(comm):
    rows, m = 3, 5
    whole = np.arange(comm.size * rows * m, dtype=float).reshape(-1, m)
    start = comm.rank * rows
    a = np.zeros((rows + 2, m))
    a[1:-1] = whole[start:start + rows]
    halo.fill(comm, a)
    assert np.array_equal(a, whole[np.arange(start - 1, start + rows + 1) % len(whole)])
    ones = np.ones((1, rows + 2, m))
    total = halo.sum_to_all(comm, ones, start, len(whole))
    wanted = np.ones(len(whole))
    for rank in range(comm.size):
        wanted[(rank * rows - 1) % len(whole)] += 1
        wanted[(rank * rows + rows) % len(whole)] += 1
    assert np.array_equal(total[0, :, 0], wanted)
    halo.accumulate(comm, ones)
    assert ones[0, 1:-1].sum() == pytest.approx((rows + 2) * m)
