"""Scenes that are refused: messages name the key, the value and what is allowed."""

import itertools
import math
import tomllib

import pytest
from refusal import refused
from scene_tables import SURFACE, TABLES, changed, refusal, rows, tables

from hpc_gfmd.contact import all_distributions, observable_names
from hpc_gfmd.scene import Scene
from hpc_gfmd.scene.not_modelled import not_modelled
from hpc_gfmd.scene.surface import KINDS
from hpc_gfmd.solvers import solver_names
from hpc_gfmd.solvers.options import read_options

BAD = tomllib.loads(r"""
[surface]
kind = ["selfaffine", 1]
hurst = [-0.1, 1.1, true, "0.8", nan, [0.8], {}]
L_over_lam_l = [0.99, 0, -1, inf, false]
lam_l_over_lam_s = [0.99, "2"]
lam_l_over_lam_r = [0.99, nan]
lam_s_over_a = [1.99]
seed = [-1, 1.0, 9223372036854775808, true]
g_rms = [0, "1"]
h_rms = [-1, 1e-200]
physical_sizes = [1, [1], [1, 0], [1, 1, 1], [1, inf]]
radius = [0, nan, [1], "1 Pa", inf, [inf, inf]]
[material]
E_star = [0, nan]
E1 = [-1]
nu1 = [0.51, true]
nu2 = [-1]
[load]
p_star = [[], [0.1, -1], [0.1, nan], [true], 0, true, "0.1", {}]
pressure = [[[0.1]], inf]
a_r = [0, 1.1, -0.1, [0.1, 2], [], "10 %"]
gap_mean = [-1, "1 Pa", true]
gap_over_h_rms = [-0.1]
approach = [-1, 0, "1 N"]
force = [-1, 0, "1 m"]
[solver]
name = [7]
accuracy = [0, 1]
residual = [-1]
precision = ["half"]
max_iterations = [0, 1e5]
nested = [1, "yes"]
low_memory = [0]
options = [3, {mass = "heavy"}]
[output]
path = ["contact.txt", ".h5", "a\u0000.h5", ""]
fields = ["gap", ["gap", "gap"], ["gaps"]]
observables = [[1], ["a_r", "a_r"]]
dtype = ["half"]
compression = [1]
[machine]
threads = [0, "all", true, 1.5]
wall_seconds = [0]
memory_gib = ["8"]
""")


def test_message_names_key_value_and_allowed_values():
    for table, keys in BAD.items():
        other_keys = {} if table == "load" else tables().get(table, {})
        for key, value in ((key, value) for key, values in keys.items() for value in values):
            message = refusal(tables() | {table: other_keys | {key: value}})
            assert message.startswith(f"{table}.{key}")
            assert ": found " in message
            assert "allowed: " in message


DETAILS = rows(r"""
surface.hurst = "0,8" | found '0,8', decimals have a point, not a comma, allowed: a number from 0
material.E_star = "50 um" | material.E_star: found '50 um', 'um' is a unit of length, not of pressure, allowed
surface.g_rms = 1e-200 | surface.g_rms: found 1e-200, allowed: a number greater than 0, from 1e-100 to 1e+100
surface.physical_sizes = 1e-4 | surface.physical_sizes: found 0.0001, allowed: a list of two, each a number greater than 0
surface = {g_rms = 1, h_rms = 1} | surface: found g_rms and h_rms
load = {} | load: not given, allowed: one of p_star, pressure, gap_mean, gap_over_h_rms, a_r, force, approach
load = {a_r = 0.1, gap_mean = 1} | load: found gap_mean and a_r, allowed: one of
load.force = 1 | load.force: found no free boundary, allowed: with a free boundary
load.approach = 1 ; surface.boundary = ["free", "periodic"] | load.approach: found a half-space that gives way without end
solver = {accuracy = 0.1, residual = 0.1} | solver: found accuracy and residual
material = {E1 = 1, E2 = 1} | material: found E1, E2, allowed: E1, nu1 (a rigid counterface); E_star; E1, nu1, E2, nu2
material.nu1 = 0.3 | material: found nu1 (nu) alone, allowed: with E1, or
material = {thickness = 1, E1 = 1, nu1 = 0, E2 = 1, nu2 = 0} | material: found thickness with E1, nu1, E2, nu2, all
material = {thickness = 1, nu1 = 0.5} | material: found nu1 = 0.5 with thickness and base = "bonded", allowed
material = {thickness = 1, nu1 = 0.3, base = "elastic", base_E = 1} | found base = "elastic" with base_E, allowed
material = {E1 = "1 GPa", thickness = "1 um", nu1 = 0.3, base = "elastic", base_E = 1.0, base_nu = 0.3} ; surface.physical_sizes = ["1 mm", "1 mm"] | all pressures
load = {approach = 1} ; material = {thickness = 1, nu1 = 0.3, base = "elastic", base_E = 1, base_nu = 0} | rigid base
surface = {L_over_lam_l = 1.9, lam_l_over_lam_s = 16.1} | = 61.18, allowed: a whole number
surface.lam_l_over_lam_r = 65 | found lam_l_over_lam_r = 65, allowed: up to lam_l_over_lam_s = 64
surface = {L_over_lam_l = 1.5, lam_l_over_lam_s = 1} | no wave vector
surface = {kind = "wave", amplitude = 0.1, n = [8, 6], periods = [0, 0]} | surface: found periods = [0, 0]
surface = {kind = "wave", amplitude = 0.1, n = 8} | surface.n: found 8, allowed: a list of two, each a whole number from 1 to 16777216
surface = {kind = "wave", amplitude = 0, n = [8, 6]} | load.p_star: found a flat surface
surface = {kind = "file", path = "z.npy", boundary = "free", mirror = true} | surface.mirror: found true, allowed: boundary = "mirror"
surface = {kind = "file", path = ["a.npy", "b.npy", "c.npy"]} | or a list of two
title = "two\nlines" | title: found 'two\nlines', allowed: one line of text
surface = {hurst = 2, seed = -1} | surface.hurst: found 2, allowed: a number from 0 to 1; surface.seed: found -1, allowed
surface.hurts = 0.8 | nearest: surface.hurst,
surface.accuracy = 1e-3 | unknown key, nearest: solver.accuracy,
surface.radius = 1 | surface: found radius with a periodic boundary, allowed: boundary = "free", or along x or y
surface.kind = "sefl-affine" | nearest: "self-affine",
xyzzy = 1 | xyzzy: unknown key, allowed: title,
material.E_star = "50 GPa" ; load.pressure = 0.1 | load.pressure: found 0.1 beside material.E_star = '50 GPa'
load.pressure = "2 MPa" | material.E_star: not given, hence 1 beside load.pressure = '2 MPa', allowed: all pressures with units
surface = {kind = "sphere", radius = "1 mm", n = [8, 8]} | surface.physical_sizes: not given, hence 1 beside surface.radius
load.force = 1 ; material.E_star = "1 GPa" ; surface = {physical_sizes = ["1 mm", "1 mm"], boundary = "free"} | load.force: found 1 beside material.E_star = '1 GPa', allowed: all pressures and forces
material.adhesion = {work = 0.1} | material.adhesion.range: not given, allowed: a number greater than 0
material.adhesion = {work = -0.1, range = 1.0} | material.adhesion.work: found -0.1, allowed: a number greater than 0
material.adhesion = {work = 0.1, range = "2 N"} | material.adhesion.range: found '2 N', 'N' is a unit of force, not of length
material.adhesion = {work = "2 nm", range = 1.0} | material.adhesion.work: found '2 nm', 'nm' is a unit of length, not of work
material.adhesion = {wrk = 0.1, range = 1.0} | material.adhesion.wrk: unknown key, nearest: material.adhesion.work, allowed: work, range, law
material.adhesion = {work = 0.1, range = 0.01, law = 3} | material.adhesion.law: found 3, allowed: "exponential" or the name of another law
material.relaxation = [[1.2, 1.0]] | material.relaxation[0]: found [1.2, 1.0], allowed: a list of [share, time], shares above 0 with a sum below 1
material.relaxation = [[0.5, 0.0]] | found [0.5, 0.0], allowed: a list of [share, time], shares above 0 with a sum below 1, times above 0
material.adhesion = 3 | material.adhesion: found 3, allowed: a table {work, range, law}
material.adhesion = {work = "50 mJ/m2", range = 0.01} | material.E_star: not given, hence 1 beside material.adhesion.work = '50 mJ/m2'
material = {adhesion = {work = 0.1, range = 0.01}, hardness = 2.0} | material.adhesion: found beside material.hardness = 2
load.p_star = [0.1, 0] | load.p_star: found 0, allowed: a number greater than 0; with load.history or load.time also 0; with material.adhesion
load.pressure = [0.1, -0.1] | load.pressure: found -0.1, allowed: a number greater than 0
load = {p_star = 0.1, branch = "retraction"} | load.branch: found "retraction", allowed: "approach"; others with material.adhesion
load = {p_star = 0.1, branch = "down"} | load.branch: found 'down', allowed: "approach" or "retraction"
load = {p_star = 0.1, unique = true} | load.unique: found true, allowed: with material.adhesion
load.a_r = 0.1 ; material.adhesion = {work = 0.1, range = 0.01} | load.a_r: found with material.adhesion, where areas jump
load.gap_mean = [0.1, 0] ; material.adhesion = {work = 0.1, range = 0.01} | load.gap_mean: found 0 with material.adhesion
load = {gap_over_h_rms = [0.1, 0], branch = "retraction"} ; material.adhesion = {work = 0.1, range = 0.01} | load.gap_over_h_rms: found 0 with
load.approach = [0.1, -0.1] ; material = {adhesion = {work = 0.1, range = 0.01}, thickness = 0.1, nu1 = 0.3} | load.approach: found -0.1 with
load = {approach = [-0.1, -0.2], branch = "retraction"} ; material = {adhesion = {work = 0.1, range = 0.01}, thickness = 0.1, nu1 = 0.3} | found -0.1 with
load.approach = [0.1, -0.1] ; material = {thickness = 0.1, nu1 = 0.3} | load.approach: found -0.1, allowed: a number greater than 0
""")  # noqa: E501


def test_details_of_messages():
    for change, words in DETAILS:
        message = refusal(changed(change))
        assert words in message
        assert "allowed: " in message or "no wave vector" in message


def test_missing_tables():
    for data, words in (
        ({"load": {"p_star": 1}}, "surface: not given, allowed: a table [surface]"),
        ({"surface": SURFACE}, "load: not given"),
        ({"surface": [SURFACE], "load": {"p_star": 1}}, "allowed: a table [surface]"),
        ({"surface": {"hurst": 1}, "load": {"p_star": 1}}, "surface.kind: not given, allowed"),
        ({}, "surface: not given, allowed: a table [surface]; load: not given"),
        (tables(solver={"options": {"mass": int("9" * 400)}}), "solver.options.mass: found 9999"),
    ):
        assert words in refusal(data)


SIMILAR_WORDS = "frictionless shared mumble gammas speedup wearable"
INSTEAD = {  # words for effects: what the message has instead of "not modelled"
    "friction_coefficient elastoPlastic viscosity wear shear_stress": "",
    "work_of_adhesion JKR Tabor_parameter pull_off": "material.adhesion = {work, range, law}",
    "viscoelastic creep_compliance prony": "material.relaxation with load.time",
    "temperature heat electric": 'output.observables = ["conductance"]',
}


@pytest.mark.parametrize("words", INSTEAD)
def test_effects_that_are_not_modelled_are_refused(words):
    for name in words.split():
        for table in TABLES:
            message = refusal(tables() | {table: tables().get(table, {}) | {name: 1}})
            assert message.startswith(f"{table}.{name}: ")
            assert (INSTEAD[words] or ": not modelled") in message
        assert (INSTEAD[words] or f"{name}: not modelled") in refusal(tables() | {name: 1})
    with refused(r"solver.options: found .*, not modelled .* allowed for the solver 'gfmd': "):
        read_options("gfmd", {"friction": 1.0}, {"mass": (0, 1)})


def test_names_of_the_package_are_not_refused():
    tables_of = [Scene.model_fields[table].annotation for table in TABLES[1:]]
    keys = {key for model in (Scene, *KINDS.values(), *tables_of) for key in model.model_fields}
    modelled_names = keys | observable_names() | all_distributions().keys() | set(solver_names())
    assert not [name for name in modelled_names | set(SIMILAR_WORDS.split()) if not_modelled(name)]


@pytest.mark.parametrize(("low", "band"), list(itertools.product([1.0, 1.7, 2.5], [1.0, 1.1, 1.2])))
def test_only_bands_without_modes_are_refused(low, band):
    high = low * band
    size = 6
    norms = [math.hypot(k, m) for k in range(size) for m in range(size)]
    has_modes = any(low * (1 - 1e-12) <= norm <= high * (1 + 1e-12) for norm in norms)
    data = tables({"L_over_lam_l": low, "lam_l_over_lam_s": band, "lam_s_over_a": 20 / high})
    if has_modes:
        assert Scene.from_dict(data).surface.n == (20, 20)
    else:
        assert "no wave vector" in refusal(data)
