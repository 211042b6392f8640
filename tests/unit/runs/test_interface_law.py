"""Interface laws interpolate few loads within the requested error."""

import numpy as np
import pytest
from contacts import rough_wall, scene_text

import hpc_gfmd
from hpc_gfmd.output.interface_law import interpolate
from hpc_gfmd.output.summary import error_bars
from hpc_gfmd.runs import in_memory
from hpc_gfmd.runs.interface_law import _Curves, interface_law
from hpc_gfmd.runs.law_sampler import Sampler
from hpc_gfmd.scene import Scene
from hpc_gfmd.util.errors import SceneError


def wall(seed=1):
    return rough_wall((2, 8, 4), seed=seed)


def formula(quantity, N=1e9):
    """(sampler of N points whose a_r is a function of pressure, list of pressures sampled)."""
    calls = []

    def sample(pressures):
        calls.extend(pressures)
        return [
            [
                {"a_r": quantity(p), "contact_points": N * quantity(p)}
                | {"a_r_error": 0.0, "gap_error": 0.0, "pressure_error": 0.0}
                for p in pressures
            ]
        ]

    return sample, calls


def test_jumps_are_located_within_the_error():
    sample, _ = formula(lambda p: float(p < 3.7))
    curves = _Curves(["a_r"], 0.01)
    curves.refine(sample, 1.0, 10.0)
    pressures, values = curves.curve("a_r")
    last_open = pressures[values > 0].max()
    first_tight = pressures[values == 0].min()
    assert last_open < 3.7 <= first_tight
    assert np.log(first_tight / last_open) <= 0.01


def test_law_of_a_wall_agrees_with_single_loads():
    surface = wall()
    names = ["a_r", "gap_mean", "stiffness", "conductance", "critical_gap_x"]
    law = interface_law(surface, 0.01, 0.5, 0.02, E_star=1.0, quantities=names)
    for p in (0.02, 0.11, 0.37):
        solution = hpc_gfmd.solve(surface, p, 1.0, observables=["conductance", "critical_gap"])
        for name in names:
            nearest = np.argmin(np.abs(np.log(law.pressure / p)))
            allowed = max(0.02, float(law.errors[name][nearest]))
            assert law(name, p) == pytest.approx(solution.value(name), rel=allowed), name
    assert law.gap_at_touch == pytest.approx(surface.heights.max() - surface.heights.mean())


def test_law_of_several_realisations(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(scene_text((2, 8, 4)))
    law = interface_law(path, 0.02, 0.2, 0.05, quantities=["a_r", "gap_mean"], realisations=3)
    assert law.surfaces == 3
    areas = [hpc_gfmd.solve(wall(seed), law.pressure[0]).a_r for seed in (1, 2, 3)]
    assert law.values["a_r"][0] == pytest.approx(np.mean(areas), rel=0.01)
    assert law.scatter["a_r"][0] == pytest.approx(np.std(areas, ddof=1), rel=0.1)


def test_the_surface_of_a_scene_is_made_once(monkeypatch):
    made = []
    original = in_memory.build_surface
    monkeypatch.setattr(
        in_memory, "build_surface", lambda *a, **k: made.append(a[2]) or original(*a, **k)
    )
    law = interface_law(Scene.from_toml(scene_text((2, 8, 4))), 0.05, 5.0, 0.05)
    assert len(law.pressure) > 3
    assert len(made) == len(set(made))


def test_stiffness_next_to_full_contact_has_the_error_of_its_last_openings():
    """On a grid six times finer it is a third less."""
    coarse, fine = (
        interface_law(
            rough_wall((2, 8, waves), g_rms=0.1), 0.06, 0.12, 0.05, quantities=["stiffness"]
        )
        for waves in (4, 24)
    )
    values = np.array([law.values["stiffness"][[0, -1]] for law in (coarse, fine)])
    missed = np.abs(values[0] / values[1] - 1)
    assert missed[1] > 0.2
    assert (missed < coarse.errors["stiffness"][[0, -1]]).all()


def test_missing_quantities_have_a_reason():
    law = interface_law(
        wall(), 0.05, 0.2, 0.05, quantities=["a_r", "conductance"], thickness=0.1, nu=0.3
    )
    assert list(law.values) == ["a_r"]
    assert any(line.startswith("conductance:") for line in law.about)


BAD = [
    ({"start": 1.0, "stop": 0.5}, "start"),
    ({"start": "1 MPa", "stop": 5.0}, "unit"),
    ({"start": -1.0, "stop": 0.5}, "positive"),
    ({"start": "1 nm", "stop": "1 MPa"}, "pressure"),
    ({"start": 0.1, "stop": 0.5, "error": 0.0}, "error"),
    ({"start": 0.1, "stop": 0.5, "error": "5%"}, "error: found '5%'"),
    ({"start": 0.1, "stop": 0.5, "hardness": 9.0, "history": True}, "history: found in a law"),
    ({"start": 0.1, "stop": 0.5, "branch": "retraction"}, "branch: found in a law"),
    ({"start": 0.1, "stop": 0.5, "relaxation": [(0.5, 1.0)]}, "relaxation: found in a law"),
    ({"start": 0.1, "stop": 0.5, "quantities": ["area"]}, "area"),
    ({"start": 0.1, "stop": 0.5, "quantities": ["perimeter"]}, "perimeter, which jump"),
    ({"start": 0.1, "stop": 0.5, "realisations": 2}, "realisations"),
]


def test_bad_arguments_are_refused():
    for arguments, reason in BAD:
        with pytest.raises(SceneError, match=reason):
            interface_law(wall(), **arguments)


def test_errors_are_those_of_the_finest_intervals():
    """A bend that the first, long intervals miss must not stay in the errors of the rows there."""

    def bend(p):
        return p**0.9 * (1 + 0.3 * np.tanh(1.5 * np.log(p / 40)))

    sample, _ = formula(bend)
    curves = _Curves(["a_r"], 0.02)
    curves.refine(sample, 1.0, 1000.0)
    pressures = sorted(curves.steps)
    errors = curves._errors("a_r", pressures, {})
    assert errors.max() <= 0.02
    at = np.geomspace(1, 1000, 999)
    missed = np.abs(interpolate(*curves.curve("a_r"), at) / bend(at) - 1)
    after = np.clip(np.searchsorted(pressures, at), 1, len(pressures) - 1)
    claimed = np.maximum(errors[after], errors[after - 1])
    assert (missed <= 1.5 * claimed + 1e-12).all()


def test_errors_contain_that_points_touch_one_by_one():
    """The area of 40 to 400 points that touch at random loads, by 30 such walls."""
    at = np.geomspace(1, 10, 500)
    beyond = []
    for seed in range(30):
        rng = np.random.default_rng(seed)
        loads = np.sort(np.append(rng.uniform(0, 10, 399), 0.01))

        def area(p, loads=loads):
            return np.searchsorted(loads, p) / 1000

        curves = _Curves(["a_r"], 0.1)
        curves.refine(formula(area, 1000)[0], 1.0, 10.0)
        pressures = sorted(curves.steps)
        errors = curves._errors("a_r", pressures, {})
        after = np.clip(np.searchsorted(pressures, at), 1, len(pressures) - 1)
        missed = np.abs(interpolate(*curves.curve("a_r"), at) / area(at) - 1)
        beyond.append(np.mean(missed > np.maximum(errors[after], errors[after - 1])))
    assert np.mean(beyond) <= 0.005  # a fifth of them without what is left to chance


@pytest.mark.parametrize("prepared", [False, True])
def test_mirror_images_touch_together(prepared):
    """They are no further points: the law of a mirrored piece is as uncertain as by its own."""
    z = wall().heights
    keys = {"physical_sizes": (1.0, 1.0), "boundary": "mirror"}
    surface = hpc_gfmd.prepare_surface(z, **keys) if prepared else z
    sampler = Sampler(surface, ["a_r"], 0.5, 1, {} if prepared else keys, None, False, 1.0)
    ((load,),) = sampler([1.0])
    assert load["contact_points"] == pytest.approx(load["a_r"] * z.size)


def test_lines_of_a_profile_touch_together():
    z = wall().heights[:, :1] * np.ones((1, 8))
    sampler = Sampler(z, ["a_r"], 0.5, 1, {"boundary": "periodic"}, None, False, 1.0)
    ((load,),) = sampler([1.0])
    assert load["contact_points"] == pytest.approx(load["a_r"] * len(z))


def test_errors_of_numbers_that_follow_from_the_area_are_those_of_tables():
    """p/a_r is as uncertain as a_r, on the other side."""
    names = ["a_r", "a_r_corrected", "contact_area", "kappa", "contact_pressure_mean", "gap_mean"]
    law = interface_law(wall(), 0.02, 0.2, 0.3, quantities=names)
    for p in law.pressure[[0, -1]]:
        solution = hpc_gfmd.solve(wall(), p, accuracy=0.03)
        for name in names:
            of_table = max(error_bars(name, solution.steps[0]))
            assert of_table > 1e-3, name
            assert law.errors[name][law.pressure == p] >= 0.9 * of_table, name


def test_quarters_of_a_periodic_wall_have_the_law_of_the_whole():
    """Mirrored pieces, each two longest waves long: their mean is within the scatter of one."""
    whole = rough_wall((4, 8, 4), seed=3, g_rms=0.1)
    corners = [(i, j) for i in (0, 64) for j in (0, 64)]
    pieces = [
        hpc_gfmd.prepare_surface(
            whole.heights[i : i + 64, j : j + 64],
            physical_sizes=(0.5, 0.5),
            detrend="tilt",
            boundary="mirror",
        )
        for i, j in corners
    ]
    of_whole = interface_law(whole, 2.5e-3, 2.5e-2, E_star=1.0)
    of_pieces = interface_law(pieces, 2.5e-3, 2.5e-2, E_star=1.0)
    at = of_pieces.pressure
    for name in ("a_r", "gap_mean", "stiffness", "conductance"):
        difference = np.abs(of_pieces.values[name] - of_whole(name, at))
        assert (difference <= of_pieces.scatter[name]).all(), name
