"""The interface law does not depend on the number of ranks."""

import json

import numpy as np
import pytest
from contacts import rough_wall, scene_text
from mpi.same import from_rank_0

from hpc_gfmd.runs.interface_law import interface_law

pytestmark = [pytest.mark.mpi, pytest.mark.two_ranks]


def test_ranks_compute_the_same_law(comm, shared_path, cli):
    """Without a communicator, rank 0 computes a law while the others wait."""
    scene = shared_path / "scene.toml"
    if comm.rank == 0:
        scene.write_text(scene_text((2, 8, 4)))
    comm.barrier()
    completed = cli("law", scene, "--from", "0.02", "--to", "0.3", "--error", "20%", "--json")
    assert completed.code == 0, completed.err
    alone = from_rank_0(comm, lambda: interface_law(scene, 0.02, 0.3, 0.2).values)
    if comm.rank > 0:
        assert not completed.out
        return
    assert_same_law(json.loads(completed.out)["law"], alone)


def test_ranks_share_heights_in_memory(comm):
    wall = rough_wall((2, 8, 4))
    law = interface_law(wall, 0.02, 0.3, 0.2, comm=comm.mpi)
    assert_same_law(law.values, interface_law(wall, 0.02, 0.3, 0.2).values)


def assert_same_law(values, expected):
    for name, of_one_process in expected.items():
        np.testing.assert_allclose(values[name], of_one_process, rtol=2e-3, atol=1e-6)
