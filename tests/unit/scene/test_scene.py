"""Scenes that are accepted: values, defaults, grid points, identity."""

import json
import tomllib

import pytest
from scene_tables import SHIPPED, rows, scene_of

from hpc_gfmd.scene import Scene, load_scene


@pytest.mark.parametrize("path", SHIPPED)
def test_shipped_scenes_load_and_survive_a_round_trip(path):
    scene = load_scene(path)
    assert Scene.from_toml(scene.to_toml()) == scene
    assert scene.warnings() == []


def test_defaults():
    scene = scene_of()
    assert scene.surface.n == (256, 256)
    assert (scene.surface.lam_l, scene.surface.h_rms, scene.solver.residual) == (0.5, None, None)
    defaults = tomllib.loads("""
        surface = {g_rms = 1, physical_sizes = [1, 1], lam_l_over_lam_r = 1}
        material.E_star = 1
        solver = {accuracy = 1e-3, name = "auto", precision = "auto", nested = "auto"}
        output.fields = []
        machine = {threads = "auto"}""")
    for table, keys in defaults.items():
        values = json.loads(getattr(scene, table).model_dump_json())
        assert {key: values[key] for key in keys} == keys


def test_alternative_keys_replace_defaults():
    scene = scene_of("surface.h_rms = 2 ; solver.residual = 1e-8")
    assert scene.surface.h_rms == 2
    assert scene.surface.g_rms is None
    assert scene.solver.residual == 1e-8
    assert scene.solver.accuracy is None


MATERIALS = [
    ("{E1 = 2.0, nu1 = 0.5, E2 = 3, nu2 = -0.5}", 1 / (0.75 / 2 + 0.75 / 3), None),
    ("{E1 = 2.0, nu1 = 0.5}", 2 / 0.75, None),
    ("{E1 = 2.0, nu1 = 0.3, thickness = 0.1}", 2 / 0.91, "bonded"),
    ("{E_star = 2.1978, nu1 = 0.3, thickness = 0.1}", 2.1978, "bonded"),
]


def test_contact_modulus_and_base_of_materials():
    for material, E_star, base in MATERIALS:
        scene = scene_of(f"material = {material}")
        assert scene.material.E_star == pytest.approx(E_star, rel=1e-15)
        assert base in (None, scene.material.base)


def test_single_loads_and_mean_pressures():
    assert scene_of("load.p_star = 1").load.p_star == (1.0,)
    for load, p0 in (("p_star = 0.1", (0.6,)), ("pressure = [5, 4]", (5, 4))):
        assert scene_of(f"load.{load}").load.p0(E_star=2, g_rms=3) == pytest.approx(p0)


ATTRACTION = "adhesion = {work = 0.1, range = 0.01}"
ATTRACTED = rows("""
p_star = [0.1, -0.1, 0]
pressure = [0.1, -0.1]
p_star = [0.1, -0.1, 0], branch = "retraction"
approach = [0.1, 0, -0.1], branch = "retraction"
""")


def test_attraction_allows_loads_of_0_and_below():
    for (load,) in ATTRACTED:
        layer = "thickness = 0.1, nu1 = 0.3"
        scene = scene_of(f"load = {{{load}}} ; material = {{{ATTRACTION}, {layer}}}")
        assert min(scene.load.prescribed[1]) == -0.1
        assert scene.material.adhesion.law == "exponential"


def test_a_branch_is_another_scene():
    approach, retraction = (
        scene_of(f"load = {{p_star = 0.1, branch = {branch}}} ; material.{ATTRACTION}")
        for branch in ('"approach"', '"retraction"')
    )
    assert approach.identity() != retraction.identity()


def test_units_of_an_attraction():
    scene = scene_of("""
surface.physical_sizes = ["1 um", "1 um"]
load.pressure = "1 MPa"
material = {E_star = "1 GPa", adhesion = {work = "50 mJ/m2", range = "2 nm"}}
""")
    adhesion = scene.material.adhesion
    assert (adhesion.work, adhesion.range) == pytest.approx((0.05, 2e-9))


POINTS = rows("""
{L_over_lam_l = 1.25, lam_l_over_lam_s = 8, lam_s_over_a = 2.5} | (25, 25)
{L_over_lam_l = 3, lam_l_over_lam_s = 1.1, lam_s_over_a = 9.090909090909092} | (30, 30)
{physical_sizes = [2, 3]} | (256, 384)
{physical_sizes = [1e-6, 0.5e-6]} | (256, 128)
{kind = "wave", amplitude = 0.1, n = [8, 6]} | (8, 6)
{kind = "sphere", radius = 1, n = [8, 8]} | (8, 8)
{kind = "file", path = "z.npy"} | None
""")


def test_numbers_of_grid_points():
    """Products of ratios that are whole up to rounding are accepted."""
    for surface, n in POINTS:
        assert str(scene_of(f"surface = {surface}").surface.n) == n


def test_a_scene_cannot_be_changed():
    scene = scene_of()
    with pytest.raises(ValueError, match="frozen"):
        scene.surface.hurst = 0.5


def test_warnings():
    assert scene_of().warnings() == []
    for change, word in rows("""
surface.lam_l_over_lam_s = 4 | self-affine
load.p_star = 1e-5 | touch
surface.physical_sizes = [1, 0.25] | isotropic
"""):
        assert word in scene_of(change).warnings()[0]


SAME = """title = "other"
machine = {threads = 4, wall_seconds = 9}
output.path = "other.h5"
output.compression = true
load.p_star = 0.1
material.E_star = 1"""
ANOTHER = """surface.seed = 2
material.E_star = 2
load.p_star = [0.1, 0.2]
load.pressure = 0.1
solver.accuracy = 1e-4
solver.options.mass = 2
output.fields = ["gap"]
output.dtype = "single\""""


CHANGES = [(line, text == SAME) for text in (SAME, ANOTHER) for line in text.splitlines()]


def test_identity_follows_what_changes_the_answer():
    for change, keeps_identity in CHANGES:
        assert (scene_of(change).identity() == scene_of().identity()) == keeps_identity


def test_identity_does_not_depend_on_the_order_of_fields():
    gap_first, pressure_first = (
        scene_of(f"output.fields = {fields}")
        for fields in (["gap", "pressure"], ["pressure", "gap"])
    )
    assert gap_first.identity() == pressure_first.identity()
