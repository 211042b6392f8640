"""`hpc-gfmd law`: the law of a scene as a table, as JSON and in files."""

import json

import numpy as np
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
    paths = [tmp_path / name for name in ("law.csv", "law.inp", "law.i")]
    outputs = [word for path in paths for word in ("-o", path)]
    text = cli.prints("law", scene, *RANGE, *outputs, "--conductivity", "50", "200")
    assert "conductance" in text
    law = hpc_gfmd.read_law(paths[0])
    for path in paths[1:]:
        of_elements = hpc_gfmd.read_law(path)
        at = np.geomspace(0.02, 0.3, 5)
        np.testing.assert_allclose(
            of_elements("gap_mean", at), law("gap_mean", at), rtol=1e-3, atol=1e-3
        )
    data = json.loads(cli.prints("law", scene, *RANGE, "--json"))
    assert data["law"]["a_r"] == pytest.approx(law.values["a_r"].tolist())


def test_plain_text_and_existing_files_are_refused(scene, cli, tmp_path):
    kept = tmp_path / "law.csv"
    kept.write_text("mine")
    assert "--force" in cli.refused("law", scene, *RANGE, "-o", kept)
    assert kept.read_text() == "mine"
    assert ".csv" in cli.refused("law", scene, *RANGE, "-o", tmp_path / "law.txt")
    assert "start" in cli.refused("law", scene, "--from", "1 nm", "--to", "1 MPa")
    assert "conductivity" in cli.refused("law", scene, *RANGE, "--conductivity", "-1")


@pytest.mark.mpi
def test_ranks_find_the_same_law(scene, mpirun, cli, ranks):
    data = json.loads(cli.prints("law", scene, *RANGE, "--json"))
    done = mpirun("law", scene, *RANGE, "--json")
    assert done.returncode == 0, done.stderr
    for name, values in data["law"].items():
        if not name.endswith("_error"):
            np.testing.assert_allclose(
                json.loads(done.stdout)["law"][name], values, rtol=2e-3, atol=1e-6
            )
