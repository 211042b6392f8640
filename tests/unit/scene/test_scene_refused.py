"""Scenes that are refused, and the words that say why."""

import itertools
import math

import pytest
from scene_tables import SURFACE, WAVE, refusal, tables

from hpc_gfmd.errors import SceneError
from hpc_gfmd.not_modelled import is_not_modelled
from hpc_gfmd.options import read_options
from hpc_gfmd.registry import distribution_names, observable_names, solver_names
from hpc_gfmd.scene import (
    File,
    Load,
    Machine,
    Material,
    Output,
    Scene,
    SelfAffine,
    Solver,
    Sphere,
    Wave,
)

BAD = {
    "surface.kind": ["selfaffine", 1],
    "surface.hurst": [-0.1, 1.1, True, "0.8", math.nan, [0.8], {}],
    "surface.L_over_lam_l": [0.99, 0, -1, math.inf, 10**400, False],
    "surface.lam_l_over_lam_s": [0.99, "2"],
    "surface.lam_l_over_lam_r": [0.99, math.nan],
    "surface.lam_s_over_a": [1.99],
    "surface.seed": [-1, 1.0, 2**63, True],
    "surface.g_rms": [0, "1"],
    "surface.h_rms": [-1, 1e-200],
    "surface.physical_sizes": [1, [1], [1, 0], [1, 1, 1], [1, math.inf]],
    "material.E_star": [0, math.nan],
    "material.E1": [-1],
    "material.nu1": [0.51, True],
    "material.nu2": [-1],
    "load.p_star": [[], [0.1, -1], [0.1, math.nan], [True], 0, True, "0.1", {}],
    "load.pressure": [[[0.1]], math.inf],
    "solver.name": [7],
    "solver.accuracy": [0, 1],
    "solver.residual": [-1],
    "solver.precision": ["half"],
    "solver.max_iterations": [0, 1e5],
    "solver.nested": [1, "yes"],
    "solver.low_memory": [0],
    "solver.options": [3, {"mass": "heavy"}],
    "output.path": ["contact.txt", ".h5", "a\0.h5", ""],
    "output.fields": ["gap", ["gap", "gap"], ["gaps"]],
    "output.observables": [[1], ["a_r", "a_r"]],
    "output.dtype": ["half"],
    "output.compression": [1],
    "machine.threads": [0, "all", True, 1.5],
    "machine.wall_seconds": [0],
    "machine.checkpoint_seconds": [-1],
    "machine.memory_gib": ["8"],
}


@pytest.mark.parametrize(("path", "value"), [(path, value) for path in BAD for value in BAD[path]])
def test_a_bad_value_is_named_with_its_key_and_what_is_allowed(path, value):
    table, key = path.split(".")
    data = tables() | {table: tables().get(table, {}) | {key: value}}
    message = refusal(data)
    assert message.startswith(path)
    assert ": found " in message
    assert "allowed: " in message


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (tables({"hurst": "0.8"}), "found '0.8', allowed: a number from 0 to 1"),
        (tables({"seed": True}), "found true"),
        (
            tables(load={"pressure": -3}),
            (
                'load.pressure: found -3, allowed: a number greater than 0, plain or as "20 MPa",'
                " or a list"
            ),
        ),
        (tables({"g_rms": -1}), "surface.g_rms: found -1, allowed: a number greater than 0"),
        (
            tables({"g_rms": 1e-200}),
            "surface.g_rms: found 1e-200, allowed: a number greater than 0, from 1e-100 to 1e+100",
        ),
        (
            tables({"physical_sizes": 1e-4}),
            "surface.physical_sizes: found 0.0001, allowed: two numbers greater than 0, [L_x, L_y]",
        ),
        (
            tables({"physical_sizes": [1, 2, 3]}),
            (
                "surface.physical_sizes: found [1, 2, 3], allowed: two numbers greater than 0,"
                " [L_x, L_y]"
            ),
        ),
        (
            tables(solver={"options": {"mass": True}}),
            "solver.options.mass: found true, allowed: a table",
        ),
        (tables(solver={"options": {"mass": int("9" * 400)}}), "solver.options.mass: found 9999"),
        (tables(load={"p_star": [0.1, -1]}), "load.p_star[1]: found -1"),
        (tables({"g_rms": 1, "h_rms": 1}), "surface: found g_rms and h_rms"),
        (tables(load={}), "load: found nothing, allowed: one of p_star, pressure"),
        (tables(load={"p_star": 1, "pressure": 1}), "load: found p_star and pressure"),
        (tables(solver={"accuracy": 0.1, "residual": 0.1}), "solver: found accuracy and residual"),
        (
            tables(material={"E_star": 1, "E1": 1, "nu1": 0, "E2": 1, "nu2": 0}),
            "material: found E_star, E1",
        ),
        (
            tables(material={"E1": 1, "E2": 1}),
            (
                "material: found E1, E2, allowed: E1, nu1 (a rigid counterface); E_star; E1, nu1,"
                " E2, nu2"
            ),
        ),
        (tables(material={"nu1": 0.3}), "material: found nu1, allowed"),
        (
            tables(material={"thickness": 1}),
            "material: found thickness with nothing else, allowed: thickness with E1, nu1",
        ),
        (
            tables(material={"thickness": 1, "E1": 1, "nu1": 0, "E2": 1, "nu2": 0}),
            "material: found thickness with E1, nu1, E2, nu2, all",
        ),
        (
            tables(material={"thickness": 1, "nu1": 0.5}),
            'material: found nu1 = 0.5 with thickness and base = "bonded", allowed',
        ),
        (
            tables(material={"thickness": 1, "nu1": 0.3, "base": "glued"}),
            "material.base: found 'glued', allowed",
        ),
        (
            tables(material={"base": "bonded"}),
            'material: found base = "bonded" without thickness, allowed: both, or none',
        ),
        (
            tables({"L_over_lam_l": 1.9, "lam_l_over_lam_s": 16.1}),
            "= 61.18, allowed: a whole number",
        ),
        (tables({"L_over_lam_l": 1e60}), "allowed: from 1 to"),
        (tables({"physical_sizes": [1, 1.7]}), "n_y = n_x * L_y/L_x"),
        (
            tables({"lam_l_over_lam_r": 65}),
            "found lam_l_over_lam_r = 65, allowed: up to lam_l_over_lam_s = 64",
        ),
        (tables({"L_over_lam_l": 1.5, "lam_l_over_lam_s": 1}), "no wave vector"),
        (tables(WAVE | {"periods": [0, 0]}), "surface: found periods = [0, 0]"),
        (tables(WAVE | {"periods": [1, 4]}), "found 4 periods on 6 points"),
        (tables(WAVE | {"n": [8, 6.0]}), "surface.n[1]: found 6.0"),
        (tables(WAVE | {"n": 8}), "surface.n: found 8, allowed: two whole numbers"),
        (tables(WAVE | {"amplitude": 0}), "load.p_star: found a flat surface"),
        (
            tables({"kind": "wave"}),
            (
                'surface.amplitude: found nothing, allowed: a number, plain or as "100 nm";'
                " surface.n: found nothing"
            ),
        ),
        ({"load": {"p_star": 1}}, "surface: found nothing, allowed: a table [surface]"),
        ({"surface": SURFACE}, "load: found nothing"),
        (tables(load=3), "load: found 3, allowed: a table [load]"),
        ({"surface": [SURFACE], "load": {"p_star": 1}}, "allowed: a table [surface]"),
        (
            {"surface": {"hurst": 1}, "load": {"p_star": 1}},
            "surface.kind: found nothing, allowed: ",
        ),
        (tables(title="two\nlines"), "title: found 'two\\nlines', allowed: one line of text"),
        (
            tables({"hurst": 2, "seed": -1}),
            (
                "surface.hurst: found 2, allowed: a number from 0 to 1; surface.seed: found -1,"
                " allowed"
            ),
        ),
        ({}, "surface: found nothing, allowed: a table [surface]; load: found nothing"),
    ],
)
def test_messages(data, words):
    assert words in refusal(data)


@pytest.mark.parametrize(
    ("data", "nearest"),
    [
        (tables({"hurts": 0.8}), "surface.hurst,"),
        ({"surface": {"kind": "self-affine", "hurts": 1}, "load": {"p_star": 1}}, "surface.hurst,"),
        (tables(solvr={"name": "gfmd"}), "solver,"),
        (tables(hurst=0.8), "surface.hurst,"),  # right key, no table
        (tables({"title": "late"}), "surface.physical_sizes (title is a key, too),"),
        (tables({"accuracy": 1e-3}), "surface.boundary (solver.accuracy is a key, too),"),
        (tables({"radius": 1}), "surface."),
        (tables({"kind": "sefl-affine"}), '"self-affine",'),
        (tables(machine={"thread": 2}), "machine.threads,"),
        (tables(xyzzy=1), "title,"),  # something is always nearest
    ],
)
def test_an_unknown_key_names_the_nearest_valid_one(data, nearest):
    message = refusal(data)
    assert f"nearest: {nearest}" in message
    assert "allowed: " in message


@pytest.mark.parametrize(
    "name",
    [
        "adhesion",
        "friction",
        "friction_coefficient",
        "mu",
        "plasticity",
        "elastoPlastic",
        "yield_stress",
        "viscosity",
        "viscoelastic",
        "hardness",
        "work_of_adhesion",
        "surface_energy",
        "gamma",
        "lubricant",
        "wear",
        "wear_rate",
        "temperature",
        "T_thermal",
        "JKR",
        "Tabor parameter",
        "shear_stress",
        "sliding_velocity",
        "relaxation_time",
        "hysteresis",
        "pull_off",
    ],
)
def test_what_is_not_modelled_is_said(name):
    for table in ("surface", "material", "load", "solver", "output", "machine"):
        message = refusal(tables() | {table: tables().get(table, {}) | {name: 1}})
        assert message.startswith(
            f"{table}.{name}: not modelled (elastic, frictionless, non-adhesive contact only),"
            " allowed: "
        )
    for table in (1, {"coefficient": 0.3}):
        assert refusal(tables(**{name: table})).startswith(f"{name}: not modelled (elastic")
    assert refusal(tables(physics={name: 1})).startswith("physics: not modelled (elastic")
    with pytest.raises(
        SceneError,
        match=r"solver.options: found .*, not modelled .* allowed for the solver 'gfmd': ",
    ):
        read_options("gfmd", {name: 1.0}, {"mass": (0, 1)})


def test_what_is_modelled_is_not_refused():
    models = (Scene, Load, Machine, Material, Output, Solver, SelfAffine, Wave, Sphere, File)
    keys = {key for model in models for key in model.model_fields}
    known = keys | observable_names() | distribution_names() | set(solver_names())
    assert not [
        name
        for name in known | {"frictionless", "shared", "mumble", "gammas", "speedup", "wearable"}
        if is_not_modelled(name)
    ]


@pytest.mark.parametrize(("low", "band"), list(itertools.product([1.0, 1.7, 2.5], [1.0, 1.1, 1.2])))
def test_a_band_without_modes_is_refused_and_no_other(low, band):
    high, size = low * band, 6
    norms = [math.hypot(k, m) for k in range(size) for m in range(size)]
    has_modes = any(low * (1 - 1e-12) <= norm <= high * (1 + 1e-12) for norm in norms)
    data = tables({"L_over_lam_l": low, "lam_l_over_lam_s": band, "lam_s_over_a": 20 / high})
    if has_modes:
        assert Scene.from_dict(data).n == (20, 20)
    else:
        assert "no wave vector" in refusal(data)


def test_all_errors_at_once_each_with_the_nearest_key_of_its_table():
    message = refusal(
        tables({"hurts": 0.8, "seed": -1}, solver={"name": "gfmd", "acuracy": 1}, load={"pstar": 1})
    )
    for words in (
        "surface.hurts: unknown key, nearest: surface.hurst",
        "surface.seed: found -1",
        "load.pstar: unknown key, nearest: load.p_star",
        "solver.acuracy: unknown key, nearest: solver.accuracy",
    ):
        assert words in message
    many = refusal(tables(**{f"bad{k}": 1 for k in range(99)}))
    assert len(many) < 1300
    assert " more)" in many
