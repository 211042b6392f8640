"""The check of the memory of each machine."""

import os

import pytest
from contacts import rough

from hpc_gfmd.runs import memory
from hpc_gfmd.runs.memory import require_memory
from hpc_gfmd.scene import Scene
from hpc_gfmd.surface import surface_size
from hpc_gfmd.util.errors import SceneError

pytestmark = pytest.mark.mpi


def test_memory_of_a_machine(comm, monkeypatch):
    """Too little memory on a machine is an error on all ranks that names what they need."""
    scene = Scene.from_dict({"surface": rough((1, 16, 2)), "load": {"p_star": [0.1]}})
    monkeypatch.setattr(memory, "available_gib", lambda: 0.1)
    with pytest.raises(
        SceneError,
        match=rf"GiB on {comm.size} of {comm.size} ranks, {os.uname().nodename} has 0.10 GiB",
    ):
        require_memory(comm, scene, surface_size(scene.surface), 1)
