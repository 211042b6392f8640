"""Notes on poor convergence, few points and doubtful input appear in every view of a result."""

import re

import numpy as np
import pytest
from contacts import heights_of, rough, scene_text
from refusal import refused
from scene_tables import tables

import hpc_gfmd
from hpc_gfmd.scene import Scene


@pytest.fixture(scope="module")
def z():
    return heights_of(rough())


@pytest.fixture
def run(tmp_path, cli):
    """run(p_star, accuracy, precision) solves a scene: (exit code, table of the run, `show`, `show
    --json`, `plot`)."""

    def solve(p_star, accuracy=1e-3, precision="auto"):
        solver = {"accuracy": accuracy, "precision": precision}
        (tmp_path / "scene.toml").write_text(scene_text((2, 16, 2), p_star, solver=solver))
        completed = cli("run scene.toml")
        shown, plotted = (cli.prints(f"{command} contact.h5") for command in ("show", "plot"))
        return completed.code, completed.out, shown, cli.data("show contact.h5"), plotted

    return solve


def test_unconverged_steps_are_marked_everywhere(run):
    code, table, shown, data, plotted = run([0.05, 0.4], 1e-9, "single")
    assert code == 3
    for text in (table, shown):
        assert "! step 1: NOT CONVERGED (stagnated)" in text
    assert data["status"] == "stagnated"
    assert [step["status"] for step in data["steps"]] == ["stagnated"] * 2
    assert min(step["pressure_error"] for step in data["steps"]) > 1e-9
    assert "! not converged: step 0, 1" in plotted


def test_few_contact_points_are_noted_everywhere(run):
    code, table, shown, data, plotted = run([1e-4])
    assert code == 0
    points = round(data["steps"][0]["a_r"] * 64**2)
    assert points < 20
    for text in (table, shown, plotted):
        assert re.search(rf"step 0: .*\b{points} points.* {100 / points:.0f} %", text)
    assert f"{points} points" in data["steps"][0]["note"]
    assert "fewer than 100 of the 64 x 64 points" in table  # a note on the scene


def test_notes_of_solutions(z):
    assert hpc_gfmd.solve(z, 0.1, boundary="periodic").note is None
    assert "points touch" in hpc_gfmd.solve(z, 1e-4).note
    assert "1 point touches" in hpc_gfmd.solve(z, 1e-9).note
    assert "full contact" in hpc_gfmd.solve(z, 5.0).note
    for shape in ((8, 8), (1, 8), (1, 1)):
        for boundary in ("periodic", "free"):
            flat = hpc_gfmd.solve(np.full(shape, 3.0), 5.0, boundary=boundary)
            assert "p* has no value" in flat.note


@pytest.mark.parametrize(
    ("scale", "load", "words"),
    [
        (1e9, {"p_star": 0.1}, ["g_rms = 1e+09", "units"]),
        (1e-2, {"pressure": 30, "E_star": 2}, ["p = 15 E*", "units"]),
    ],
)
def test_numbers_in_different_units_are_noted(z, scale, load, words):
    with pytest.warns(UserWarning, match=re.escape(words[0])):
        solution = hpc_gfmd.solve(scale * z, **load)
    (note,) = (*solution.notes, *filter(None, [solution.note]))
    assert all(word in note for word in words)


def test_yielding_metals_are_noted(z):
    """The note compares the mean contact pressure with E*; rubber and solids with a hardness have
    none."""
    sizes = {"physical_sizes": ("1 mm", "1 mm"), "boundary": "periodic"}
    steel = hpc_gfmd.solve(1e-3 * z, "500 MPa", "110 GPa", **sizes)
    share = 110e9 / steel.value("contact_pressure_mean")
    assert share < 50
    assert f"E*/{share:.2g}" in steel.note
    assert "give the hardness" in steel.note
    for material in ({"E_star": "5 MPa"}, {"E_star": "110 GPa", "hardness": "6 GPa"}):
        load = "20 kPa" if "hardness" not in material else "500 MPa"
        note = hpc_gfmd.solve(1e-3 * z, load, **material, **sizes).note
        assert "yield" not in (note or "")
    gentle = hpc_gfmd.solve(1e-6 * z, "0.5 MPa", "110 GPa", **sizes)
    assert "yield" not in (gentle.note or "")


def test_notes_on_height_maps_appear_once_everywhere(z, tmp_path, cli):
    """Heights in nm beside sizes in m."""
    np.save("z.npy", 1e9 * z)
    (tmp_path / "s.toml").write_text(
        'surface = {kind = "file", path = "z.npy", physical_sizes = [1, 1]}\nload.p_star = [0.1,'
        " 0.2]"
    )
    log = cli.prints("run s.toml")
    for text in (log, cli.prints("show contact.h5")):
        assert text.count("note: g_rms = 1e+09") == 1
    with pytest.warns(hpc_gfmd.SurfaceWarning, match="g_rms = 1e"):
        assert hpc_gfmd.solve("s.toml").notes == hpc_gfmd.load("contact.h5").notes


def test_arguments_without_an_effect_are_refused():
    """Overrides of a Scene, which has no file, and low memory without coarser grids."""
    with refused("^overrides: found with a Scene"):
        hpc_gfmd.run(Scene.from_dict(tables()), ["load.p_star=0.1"], quiet=True)
    with refused(r"^solver.nested: found false, allowed with solver.low_memory: true"):
        hpc_gfmd.run(
            Scene.from_dict(tables(solver={"low_memory": True, "nested": False})), quiet=True
        )
