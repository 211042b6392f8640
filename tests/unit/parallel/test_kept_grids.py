"""Tables of grids are kept for the next contact of the same size, without changing results."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
from contacts import rough_wall

import hpc_gfmd
from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.parallel.grid import Grid

SERIAL = SerialComm()


def test_transforms_are_kept_per_grid_and_thread():
    def transforms(n, sizes, comm=SERIAL, **options):
        return Grid.kept(n, sizes, comm, **options).fft(np.float64)

    kept = transforms((12, 10), (1, 1))
    assert kept is transforms([12, 10], [1.0, 1.0])
    assert kept is not transforms((12, 10), (1, 2))
    assert kept is not transforms((12, 10), (1, 1), nominal=(8, 10))
    assert kept is not Grid((12, 10)).fft(np.float64)
    another_comm = SerialComm()
    assert kept is transforms((12, 10), (1, 1), another_comm)
    assert Grid.kept((12, 10), (1, 1), another_comm).comm is another_comm
    with ThreadPoolExecutor(1) as pool:
        assert pool.submit(transforms, (12, 10), (1, 1)).result() is not kept


def test_contacts_in_threads_do_not_share_memory():
    """Solutions do not depend on what other threads solve at the same time."""
    walls = [rough_wall(seed=seed) for seed in range(4)]
    alone = [hpc_gfmd.solve(wall, p_star=0.1).pressure for wall in walls]
    with ThreadPoolExecutor(2) as pool:
        again = list(pool.map(lambda wall: hpc_gfmd.solve(wall, p_star=0.1).pressure, walls * 2))
    for pressure, expected in zip(again, alone * 2, strict=True):
        assert np.allclose(pressure, expected, rtol=1e-9, atol=1e-9 * expected.max())
