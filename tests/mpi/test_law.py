"""The interface law of a scene does not depend on the number of ranks."""

import json

import numpy as np
import pytest
from contacts import scene_text
from mpi.same import from_rank_0

from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.runs.interface_law import interface_law

pytestmark = [pytest.mark.mpi, pytest.mark.two_ranks]


def test_ranks_compute_the_same_law(comm, shared_path, cli):
    scene = shared_path / "scene.toml"
    if comm.rank == 0:
        scene.write_text(scene_text((2, 8, 4)))
    comm.barrier()
    completed = cli("law", scene, "--from", "0.02", "--to", "0.3", "--error", "20%", "--json")
    assert completed.code == 0, completed.err
    alone = from_rank_0(
        comm, lambda: interface_law(scene, 0.02, 0.3, 0.2, comm=SerialComm()).values
    )
    if comm.rank > 0:
        assert not completed.out
        return
    on_ranks = json.loads(completed.out)["law"]
    for name, values in alone.items():
        np.testing.assert_allclose(on_ranks[name], values, rtol=2e-3, atol=1e-6)
