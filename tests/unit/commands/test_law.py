"""`hpc-gfmd law`: the interface law of a scene as a table, as JSON and in files."""

import json

import pytest
from contacts import scene_text

import hpc_gfmd

RANGE = ("--from", "0.02", "--to", "0.3", "--error", "5%")


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(scene_text((2, 8, 4)))
    return path


def test_files_and_table(scene, cli, tmp_path):
    """The law has its own loads: the scene needs none."""
    paths = [tmp_path / name for name in ("law.csv", "law.inp")]
    outputs = [word for path in paths for word in ("-o", path)]
    scene.write_text(scene.read_text().partition("[load]")[0])
    text = cli.prints("law", scene, *RANGE, *outputs, "--conductivity", "50", "200")
    assert "conductance" in text
    law = hpc_gfmd.read_law(paths[0])
    assert "*GAP CONDUCTANCE" in paths[1].read_text()
    data = json.loads(cli.prints("law", scene, *RANGE, "--json"))
    assert data["law"]["a_r"] == pytest.approx(law.values["a_r"].tolist())


def test_existing_files_and_bad_arguments_are_refused(scene, cli, tmp_path):
    existing = tmp_path / "law.csv"
    existing.write_text("mine")
    assert "--force" in cli.refused("law", scene, *RANGE, "-o", existing)
    assert existing.read_text() == "mine"
    assert ".csv" in cli.refused("law", scene, *RANGE, "-o", tmp_path / "law.txt")
    assert "start" in cli.refused("law", scene, "--from", "1 nm", "--to", "1 MPa")
    assert "conductivity" in cli.refused("law", scene, *RANGE, "--conductivity", "-1")


def test_bodies_that_relax_are_refused(scene, cli):
    """With their loads or without, by a message that names the key and the scene."""
    relaxes = ("--set", "material.relaxation=[[0.5, 1.0]]")
    for more in ((), ("--set", "load.time=0.0")):
        message = cli.refused("law", scene, *RANGE, *relaxes, *more)
        assert "scene.toml: material.relaxation: found in a law, which would depend on" in message


UNWRITABLE = [
    (("-o", "missing/law.csv"), "folder"),
    (("-o", "law.inp", "--quantities", "a_r"), "gap_mean"),
    (("-o", "law.inp", "--quantities", "gap_mean", "--conductivity", "50"), "conductance"),
    (("-o", "law.inp", "--name", "A B"), "name"),
]


def test_what_cannot_be_written_is_refused_before_a_load(scene, cli, monkeypatch):
    monkeypatch.setattr("hpc_gfmd.runs.interface_law.interface_law", None)
    monkeypatch.chdir(scene.parent)
    for arguments, reason in UNWRITABLE:
        assert reason in cli.refused("law", scene, *RANGE, *arguments)


def test_a_law_with_a_load_that_is_not_converged(scene, cli, tmp_path):
    path = tmp_path / "law.csv"
    wide = ["--from", "0.02", "--to", "0.3", "--error", "50%"]
    few = "solver.max_iterations=1"
    completed = cli("law", scene, *wide, "--quantities", "a_r", "--set", few, "-q", "-o", path)
    assert completed.code == 3
    law = hpc_gfmd.read_law(path)
    assert not law.converged
    assert "a load at 0.02 is max_iterations" in law.about


def test_a_load_that_is_not_converged_is_named_with_its_unit():
    """The law itself may be in other units than the load that is named."""
    surface = hpc_gfmd.make_surface(
        "wave", amplitude="10 nm", n=(32, 32), physical_sizes=("1 um", "1 um")
    )
    keys = {"E_star": "1 GPa", "max_iterations": 1, "quantities": ["gap_mean"]}
    law = hpc_gfmd.interface_law(surface, "1 MPa", "9 MPa", 0.5, **keys)
    assert "a load at 1e+06 Pa is max_iterations" in law.in_units("mm-N-MPa").about
