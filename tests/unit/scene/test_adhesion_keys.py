"""material.adhesion in a scene: keys, units, and combinations that are refused."""

import pytest
from scene_tables import tables

from hpc_gfmd.scene import Scene
from hpc_gfmd.util.errors import SceneError

ATTRACTION = {"work": 0.1, "range": 0.01}
MEASURED = {
    "surface": {
        "kind": "wave",
        "amplitude": "1 nm",
        "n": [16, 16],
        "physical_sizes": ["1 um", "1 um"],
    }
}


def scene(load=None, adhesion=ATTRACTION, material=(), **changed):
    """The Scene of the reference tables with adhesion; changed: further tables."""
    material = dict(material) | ({} if adhesion is None else {"adhesion": adhesion})
    return Scene.from_dict(tables(load=load or {"p_star": 0.1}, material=material, **changed))


def test_keys_and_defaults():
    adhesion = scene().material.adhesion
    assert (adhesion.work, adhesion.range, adhesion.law) == (0.1, 0.01, "exponential")
    assert scene(None, None).material.adhesion is None
    made = scene({"p_star": [0.1, -0.1, 0], "branch": "retraction"})
    assert Scene.from_toml(made.to_toml()) == made
    assert made.identity() != scene({"p_star": [0.1, -0.1, 0]}).identity()


@pytest.mark.parametrize("work", ["50 mJ/m2", "50 mJ/m^2", "0.05 N/m", "0.05 J/m**2"])
def test_units(work):
    material = {"E_star": "1 GPa"}
    adhesion = {"work": work, "range": "2 nm"}
    made = scene({"pressure": "1 MPa"}, adhesion, material, **MEASURED).material.adhesion
    assert made.work == pytest.approx(0.05)
    assert made.range == pytest.approx(2e-9)


@pytest.mark.parametrize(
    ("adhesion", "words"),
    [
        ({"work": 0.1}, ["material.adhesion.range", "not given"]),
        ({"work": -0.1, "range": 1.0}, ["material.adhesion.work", "found -0.1", "greater than 0"]),
        ({"work": 0.1, "range": "2 N"}, ["material.adhesion.range", "'N'", "a unit of force"]),
        ({"work": "2 nm", "range": 1.0}, ["material.adhesion.work", "a unit of length"]),
        ({"wrk": 0.1, "range": 1.0}, ["material.adhesion.wrk", "nearest", "work, range, law"]),
        (ATTRACTION | {"law": 3}, ["material.adhesion.law", "found 3", "exponential"]),
        (3, ["material.adhesion", "found 3", "a table"]),
        ({"work": "50 mJ/m2", "range": 0.01}, ["material.adhesion.work", "units"]),
    ],
)
def test_bad_tables_are_refused(adhesion, words):
    with pytest.raises(SceneError) as refusal:
        scene(adhesion=adhesion)
    for word in words:
        assert word in str(refusal.value)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    "load", [{"p_star": -0.1}, {"p_star": [0.1, 0]}, {"pressure": [0.1, -0.1]}]
)
def test_tensile_loads_need_adhesion(load):
    assert scene(load).load.prescribed[1]
    (name,) = load
    with pytest.raises(SceneError, match=rf"load.{name}: found .*allowed: a number greater than 0"):
        scene(load, None)


def test_a_branch_needs_adhesion():
    with pytest.raises(SceneError, match=r'load.branch: found "retraction", allowed'):
        scene({"p_star": 0.1, "branch": "retraction"}, None)
    with pytest.raises(SceneError, match=r"load.unique: found true, allowed"):
        scene({"p_star": 0.1, "unique": True}, None)
    with pytest.raises(SceneError, match=r"load.branch: found 'down', allowed"):
        scene({"p_star": 0.1, "branch": "down"})


def test_adhesion_excludes_a_hardness():
    with pytest.raises(SceneError, match=r"material.adhesion: found .*hardness = 2, allowed"):
        scene(material={"hardness": 2.0})


def test_an_area_is_refused_because_it_jumps():
    with pytest.raises(SceneError, match=r"load.a_r: found .*allowed: p_star, pressure, gap_mean"):
        scene({"a_r": 0.1})


LAYER = {"thickness": 0.1, "nu1": 0.3}


@pytest.mark.parametrize(
    ("load", "value"),
    [
        ({"gap_mean": [0.1, 0]}, "0"),
        ({"gap_over_h_rms": [0.1, 0], "branch": "retraction"}, "0"),
        ({"approach": [0.1, -0.1]}, "-0.1"),
        ({"approach": [-0.1, -0.2], "branch": "retraction"}, "-0.1"),
    ],
)
def test_gaps_and_approaches_up_to_0_are_refused(load, value):
    name = next(iter(load))
    material = LAYER if name == "approach" else {}
    with pytest.raises(SceneError, match=rf"load.{name}: found {value} with material.adhesion"):
        scene(load, material=material)


def test_negative_approaches_need_adhesion_and_retraction():
    assert scene({"approach": [0.1, 0, -0.1], "branch": "retraction"}, material=LAYER)
    with pytest.raises(SceneError, match=r"load.approach: found -0.1, allowed: a number greater"):
        scene({"approach": [0.1, -0.1]}, None, LAYER)
