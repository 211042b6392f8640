"""Histories with half the time steps."""

import pytest
from contacts import rough

import hpc_gfmd
from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.runs.halved import changes_by_halving, require_steps, text_of, with_halved_steps
from hpc_gfmd.runs.in_memory import solve_loads, surfaces_of_scene
from hpc_gfmd.scene import Scene
from hpc_gfmd.util.errors import SceneError

SERIAL = SerialComm()
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
        changes.append(changes_by_halving(scene, steps, SERIAL))
    assert changes[1]["gap_mean"] < 0.2 * changes[0]["gap_mean"]
    assert changes[0]["p"] == 0


@pytest.mark.parametrize(("step", "least", "most"), [(0.3, 1.3, 1.4), (1, 1.3, 1.4), (100, 1.6, 3)])
def test_the_error_is_larger_than_the_change(step, least, most):
    """Creep of relaxation times of 1 and 10 s: the printed line says how much larger."""
    tables = TABLES | {"material": {"E_star": "1 GPa", "relaxation": [[0.6, "1 s"], [0.3, "10 s"]]}}
    times = ["0 s", f"{step} s"]
    scene = Scene.from_dict(tables | {"load": {"pressure": "2 MPa", "time": times}})
    gaps = []
    for _ in range(6):
        loads, _ = solve_loads(SERIAL, scene, surfaces_of_scene(SERIAL, scene), False, False)
        gaps.append(loads.steps[-1]["gap_mean"])
        scene = with_halved_steps(scene)
    change, error = (abs(gaps[k] / gaps[0] - 1) for k in (1, -1))
    assert least < error / change < most
    assert "1.3 times as large, up to 3 times if" in text_of({"gap_mean": change})


def test_nothing_to_halve():
    tables = TABLES | {"load": {"pressure": "2 MPa"}, "material": {"E_star": "1 GPa"}}
    with pytest.raises(SceneError, match=r"--halve-steps: .* load\.time"):
        require_steps(Scene.from_dict(tables))
