"""Quantities with units in a scene: parsing, equality with plain SI numbers, and output."""

import h5py
import pytest
from scene_tables import scene_of

from hpc_gfmd.runs.simulation import run_scene
from hpc_gfmd.scene import Scene
from hpc_gfmd.util.quantities import factor, parse, prefixed

TEXTS = [
    ("100 um", "length", 1e-4),
    ("100um", "length", 1e-4),
    ("1.5e2 µm", "length", 1.5e-4),
    ("3 Å", "length", 3e-10),
    (" .5 mm ", "length", 5e-4),
    ("50 GPa", "pressure", 5e10),
    ("20 N/mm^2", "pressure", 2e7),
    ("2 bar", "pressure", 2e5),
    ("50 mJ/m2", "work", 0.05),
    ("50 mJ/m^2", "work", 0.05),
    ("0.05 N/m", "work", 0.05),
    ("0.05 J/m**2", "work", 0.05),
]


def test_parse():
    for text, dimension, value in TEXTS:
        assert parse(text, dimension) == pytest.approx(value, rel=1e-12)


MALFORMED = [
    "",
    "um",
    "3",
    "3 kg",
    "3 GPa",
    "3 quux",
    "nan m",
    "9**9**9 m",
    "1 m; 2",
    "__import__('os') m",
    "1 " + "m*" * 50,
    "1,5 um",
]


def test_malformed_lengths_are_refused():
    for text in MALFORMED:
        with pytest.raises(
            ValueError, match=r"not a number with a unit|no unit of length|not of length|a comma"
        ):
            parse(text, "length")


def test_prefixes():
    assert prefixed([2e7, 3e3], "Pa") == (1e6, "MPa")
    assert prefixed([1e-6], "m") == (1e-6, "um")
    assert prefixed([999e-9], "m") == (1e-9, "nm")
    assert prefixed([float("nan"), None, 0.0], "m") == (1.0, "m")
    assert prefixed([1e-40], "m")[1] == "fm"
    assert prefixed([5.0], "") == (1.0, "")
    assert factor("um") == 1e-6


UNITS = """
surface = {physical_sizes = ["100 um", "0.1 mm"], h_rms = "200 nm"}
material = {E1 = "50 GPa", nu1 = 0.3, E2 = "200 GPa", nu2 = 0.25}
load = {pressure = ["20 MPa", "0.1 GPa"]}
"""
PLAIN = """
surface = {physical_sizes = [1e-4, 1e-4], h_rms = 2e-7}
material = {E1 = 5e10, nu1 = 0.3, E2 = 2e11, nu2 = 0.25}
load = {pressure = [2e7, 1e8]}
"""


def test_units_give_the_solution_of_si_numbers(cli):
    named = scene_of(UNITS)
    plain = scene_of(PLAIN)
    assert Scene.from_toml(named.to_toml()) == named
    assert '"50 GPa"' in named.to_toml()
    runs = [run_scene(scene, out=f"{k}.h5", quiet=True) for k, scene in enumerate((named, plain))]
    for with_units, without_units in zip(runs[0].steps, runs[1].steps):
        for key in ("a_r", "p", "gap_mean"):
            assert with_units[key] == pytest.approx(without_units[key], rel=1e-6)
    with h5py.File("0.h5") as file:
        assert (file["surface"].attrs["unit"], file["surface"].attrs["pressure_unit"]) == (
            "m",
            "Pa",
        )
    shown = cli.prints("show 0.h5")
    for words in ("L = 100 x 100 um", "h_rms = 200 nm", "[MPa]", "[nm]", " 20 ", " 100 "):
        assert words in shown
    shown = cli.prints("show 1.h5")
    assert "[pressure]" in shown
    assert "h_rms = 2e-07" in shown
