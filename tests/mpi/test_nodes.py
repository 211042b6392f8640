"""Ranks of a node transpose in shared memory, others by messages; results are those of one rank."""

import errno
import gc
import os

import numpy as np
import pytest
from contacts import rough, sweep_of
from decomposition import Share, busiest, share_of, transpose_traffic
from mpi.nodes import NODES, PER_NODE, on_pretended_nodes, sent_in_a_step
from transfers import assert_same_on_slabs

from hpc_gfmd.operators import hierarchy
from hpc_gfmd.parallel import shared
from hpc_gfmd.parallel.comm import MpiComm
from hpc_gfmd.parallel.grid import Grid

pytestmark = pytest.mark.mpi
on_nodes = pytest.mark.parametrize("nodes", NODES)


@pytest.fixture
def machines(comm, nodes, monkeypatch):
    """Return the communicator of all ranks, as if they were on these nodes."""
    return comm if comm.size == 1 else on_pretended_nodes(comm, NODES[nodes], monkeypatch)


@on_nodes
def test_transforms(machines):
    """Odd sizes, ranks without rows, ranks without columns, threads."""
    for n in [(3, 16), (201, 301), (40, 2), (2, 1)]:
        for threads in (1, 2):
            assert_same_on_slabs(machines, n, threads=threads)


@on_nodes
def test_messages_are_those_between_nodes(machines, nodes, monkeypatch):
    """An iteration sends the planned messages, also of levels that are spread over ranks;
    transposes within a node need none."""
    if machines.size == 1:
        return
    monkeypatch.setattr(hierarchy, "COARSEST_POINTS", 64)
    monkeypatch.setattr(hierarchy, "UNGATHERED_POINTS", 64)
    monkeypatch.setattr(hierarchy, "FEWEST_ROWS", 4)
    for surface in (rough((1, 31, 2.0), boundary="free"), rough((2, 32, 4))):
        sweep = sweep_of(surface, comm=machines, accuracy=1e-2, precision="single")
        sweep.solve(0.1 * sweep.surface.g_rms)
        share = Share(sweep.surface.grid, sweep.dtype)
        assert sent_in_a_step(sweep) == share.traffic
        assert all(sent > 0 for sent in (*share.level_traffic, *share.reduction_traffic))
    is_one_node = len(machines.node_ranks) == machines.size
    assert (transpose_traffic(share.layout) == (0, 0)) == is_one_node
    if nodes in PER_NODE:
        n = sweep.surface.grid.n
        per_node = PER_NODE[nodes] or machines.size
        planned = share_of(n, sweep.dtype, machines.size, machines.rank, per_node=per_node)
        assert planned.traffic == share.traffic
        # the ranks that are looked at find the largest numbers
        shares = busiest(n, sweep.dtype, machines.size, per_node=per_node)
        largest = np.max([busy.traffic for busy in shares], axis=0)
        assert list(machines.max(share.traffic)) == largest.tolist()


def test_no_shared_memory(comm, monkeypatch):
    """If a rank cannot open the memory of another, as in another container, all data are sent."""
    if comm.size == 1:
        return
    real = os.readlink
    monkeypatch.setattr(
        os, "readlink", lambda path: real("/proc/self/exe") if comm.rank == 1 else real(path)
    )
    separate = MpiComm(comm.mpi)
    assert list(separate.node_ranks) == [comm.rank]
    assert_same_on_slabs(separate, (31, 37))


def test_too_much_memory_is_an_error_on_all_ranks(comm, monkeypatch):
    if comm.size == 1:
        return
    node = comm.node

    def full(file, size):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "ftruncate", full)
    with pytest.raises(OSError, match="No space left" if node.rank == 0 else "no memory in common"):
        shared.common_memory(node, 2**20)
    comm.barrier()


def test_memory_is_released_with_the_grid(comm):
    """Without communication, no descriptor or mapping of an unused grid remains."""
    if comm.size == 1:
        return

    def mapped():
        with open("/proc/self/maps") as maps:
            return sum("memfd:hpc-gfmd" in line for line in maps), len(os.listdir("/proc/self/fd"))

    gc.collect()
    maps, files = mapped()
    grid = Grid((64, 64), comm=comm)
    grid.fft(np.float32)
    assert mapped() == (maps + 1, files + 1)
    del grid
    gc.collect()
    assert mapped() == (maps, files)
