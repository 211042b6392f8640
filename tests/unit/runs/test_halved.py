"""Histories with half the time steps."""

import pytest
from contacts import rough

import hpc_gfmd
from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.runs.halved import changes_by_halving, require_steps, with_halved_steps
from hpc_gfmd.scene import Scene
from hpc_gfmd.util.errors import SceneError

TABLES = {
    "surface": rough((2, 8, 2), physical_sizes=["1 mm", "1 mm"], g_rms=0.1),
    "material": {"E_star": "1 GPa", "relaxation": [[0.8, "1 s"]]},
    "load": {
        "pressure": ["2 MPa", "6 MPa", "3 MPa", "3 MPa"],
        "time": ["0 s", "2 s", "2 s", "4 s"],
    },
    "solver": {"accuracy": 1e-5},
}


def test_loads_in_the_middle_of_steps():
    """None at a jump; the new scene can be written and read."""
    scene = Scene.from_toml(with_halved_steps(Scene.from_dict(TABLES)).to_toml())
    assert scene.load.time == pytest.approx((0, 1, 2, 2, 3, 4))
    _, pressures = scene.load.prescribed
    assert pressures == pytest.approx((2e6, 4e6, 6e6, 3e6, 3e6, 3e6))


def test_changes(tmp_path):
    """Of a coarse history more than of a fine one."""
    changes = []
    for times in (["0 s", "2 s", "2 s", "4 s"], ["0 s", "0.2 s", "0.2 s", "0.4 s"]):
        scene = Scene.from_dict(TABLES | {"load": TABLES["load"] | {"time": times}})
        steps = hpc_gfmd.run(scene, out=tmp_path / "x.h5", force=True, quiet=True).steps
        changes.append(changes_by_halving(scene, steps, SerialComm()))
    assert changes[1]["gap_mean"] < 0.2 * changes[0]["gap_mean"]
    assert changes[0]["p"] == 0


def test_nothing_to_halve():
    tables = TABLES | {"load": {"pressure": "2 MPa"}, "material": {"E_star": "1 GPa"}}
    with pytest.raises(SceneError, match=r"--halve-steps: .* load\.time"):
        require_steps(Scene.from_dict(tables))
