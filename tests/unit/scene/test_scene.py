"""Scenes that are accepted: values, defaults, grid points, identity."""

import pytest
from scene_tables import FILE, SHIPPED, SPHERE, WAVE, tables

from hpc_gfmd.scene import Scene, load_scene


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_shipped_scenes_load_and_survive_a_round_trip(path):
    scene = load_scene(path)
    assert Scene.from_toml(scene.to_toml()) == scene
    assert scene.warnings() == []


def test_the_main_job():
    scene = load_scene(next(path for path in SHIPPED if path.stem == "rough"))
    assert scene.n == (1024, 1024)
    assert scene.load.p_star == (0.007, 0.353)
    assert (scene.surface.eps_t, scene.surface.eps_f, scene.surface.eps_c) == (
        1 / 2,
        1 / 256,
        1 / 2,
    )
    assert scene.output.fields == ("pressure", "gap")


def test_defaults():
    scene = Scene.from_dict(tables())
    assert scene.n == (256, 256)
    assert scene.surface.g_rms == 1
    assert scene.surface.h_rms is None
    assert scene.surface.physical_sizes == (1, 1)
    assert scene.surface.lam_l == 0.5
    assert scene.surface.lam_l_over_lam_r == 1
    assert scene.material.E_star == 1
    assert scene.solver.accuracy == 1e-3
    assert scene.solver.residual is None
    assert scene.solver.name == scene.solver.precision == scene.solver.nested == "auto"
    assert scene.output.fields == ()
    assert scene.output.observables is None
    assert scene.machine.threads == 1
    assert scene.machine.checkpoint_seconds == 600


def test_alternatives_switch_the_default_off():
    scene = Scene.from_dict(tables({"h_rms": 2}, solver={"residual": 1e-8}))
    assert scene.surface.h_rms == 2
    assert scene.surface.g_rms is None
    assert scene.solver.residual == 1e-8
    assert scene.solver.accuracy is None
    assert Scene.from_toml(scene.to_toml()) == scene


@pytest.mark.parametrize(
    ("material", "E_star", "base"),
    [
        ({"E1": 2.0, "nu1": 0.5, "E2": 3, "nu2": -0.5}, 1 / (0.75 / 2 + 0.75 / 3), None),
        ({"E1": 2.0, "nu1": 0.5}, 2 / 0.75, None),
        ({"E1": 2.0, "nu1": 0.3, "thickness": 0.1}, 2 / 0.91, "bonded"),
        ({"E_star": 2 / 0.91, "nu1": 0.3, "thickness": 0.1}, 2 / 0.91, "bonded"),
    ],
    ids=["two solids", "a rigid counterface", "a layer", "a layer by E*"],
)
def test_material(material, E_star, base):
    scene = Scene.from_dict(tables(material=material))
    assert scene.material.E_star == pytest.approx(E_star, rel=1e-15)
    assert base in (None, scene.material.base)
    assert Scene.from_toml(scene.to_toml()) == scene


def test_one_load_is_a_list_of_one():
    assert Scene.from_dict(tables(load={"p_star": 1})).load.p_star == (1.0,)
    assert Scene.from_dict(tables(load={"p_star": 0.1})).load.p0(
        E_star=2, g_rms=3
    ) == pytest.approx((0.6,))
    assert Scene.from_dict(tables(load={"pressure": [5, 4]})).load.p0(E_star=2, g_rms=3) == (5, 4)


@pytest.mark.parametrize(
    ("change", "n"),
    [
        ({"L_over_lam_l": 1.25, "lam_l_over_lam_s": 8, "lam_s_over_a": 2.5}, (25, 25)),
        (
            {"L_over_lam_l": 3, "lam_l_over_lam_s": 1.1, "lam_s_over_a": 1 / 0.11},
            (30, 30),
        ),  # up to rounding
        ({"physical_sizes": [2, 3]}, (256, 384)),
        ({"physical_sizes": [1e-6, 0.5e-6]}, (256, 128)),
    ],
)
def test_grid_points_from_the_ratios(change, n):
    assert Scene.from_dict(tables(change)).n == n


def test_grid_points_of_the_other_kinds():
    assert Scene.from_dict(tables(WAVE)).n == (8, 6)
    assert Scene.from_dict(tables(SPHERE)).n == (8, 8)
    assert Scene.from_dict(tables(FILE)).n is None


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("a.npy", "npy"),
        ("a.H5", "hdf5"),
        ("a.hdf5", "hdf5"),
        ("a.nc", "netcdf"),
        ("a.sdf", "other"),
        ("npy", "other"),
    ],
)
def test_file_format_by_extension(name, kind):
    assert Scene.from_dict(tables({"kind": "file", "path": name})).surface.format == kind


def test_a_scene_cannot_be_changed():
    scene = Scene.from_dict(tables())
    with pytest.raises(ValueError, match="frozen"):
        scene.surface.hurst = 0.5


def test_warnings():
    assert Scene.from_dict(tables()).warnings() == []
    assert "self-affine" in Scene.from_dict(tables({"lam_l_over_lam_s": 4})).warnings()[0]
    assert "touch" in Scene.from_dict(tables(load={"p_star": 1e-5})).warnings()[0]
    assert "isotropic" in Scene.from_dict(tables({"physical_sizes": [1, 0.25]})).warnings()[0]


@pytest.mark.parametrize(
    "change",
    [
        {"title": "other"},
        {"machine": {"threads": 4, "wall_seconds": 9}},
        {"output": {"path": "other.h5"}},
        {"output": {"compression": True}},
        {"load": {"p_star": 0.1}},
        {"material": {"E_star": 1}},
    ],
)
def test_identity_ignores_what_does_not_change_the_answer(change):
    assert Scene.from_dict(tables(**change)).identity() == Scene.from_dict(tables()).identity()


@pytest.mark.parametrize(
    "change",
    [
        {"surface": {"seed": 2}},
        {"material": {"E_star": 2}},
        {"load": {"p_star": [0.1, 0.2]}},
        {"load": {"pressure": 0.1}},
        {"solver": {"accuracy": 1e-4}},
        {"solver": {"options": {"mass": 2}}},
        {"output": {"fields": ["gap"]}},
        {"output": {"dtype": "single"}},
    ],
)
def test_identity_follows_what_changes_the_answer(change):
    assert Scene.from_dict(tables(**change)).identity() != Scene.from_dict(tables()).identity()


def test_identity_does_not_depend_on_the_order_of_fields():
    one, other = (
        Scene.from_dict(tables(output={"fields": fields}))
        for fields in (["gap", "pressure"], ["pressure", "gap"])
    )
    assert one.identity() == other.identity()
