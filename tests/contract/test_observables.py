"""What every observable promises. A new file in hpc_gfmd/contact is tested by being there."""

from math import isfinite

import numpy as np
import pytest
from contacts import EXACT, rough, sweep_of

from hpc_gfmd.commands.show import as_dict, as_text
from hpc_gfmd.contact import (
    all_numbers,
    all_observables,
    default_observables,
    duality,
    observables_named,
)
from hpc_gfmd.output.numbers import said_of
from hpc_gfmd.output.read import read_result
from hpc_gfmd.runs.simulation import run_scene
from hpc_gfmd.scene import Scene
from hpc_gfmd.util.errors import SceneError

every_observable = pytest.mark.parametrize("name", all_observables())
FREE, HARD = rough((1, 8, 4), boundary="free"), {"hardness": 0.5}  # where all but one exist


@pytest.fixture(scope="module")
def contact():
    made = sweep_of(FREE, duality=True, layer=HARD, accuracy=1e-3)
    made.solve(0.05)
    return made.solve(0.1)


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    path = tmp_path_factory.mktemp("observables") / "all.h5"
    scene = Scene.from_dict(
        {
            "surface": FREE,
            "material": HARD,
            "load": {"p_star": [0.05, 0.1]},
            "output": {"observables": list(all_observables())},
        }
    )
    assert run_scene(scene, out=path, quiet=True).exit_code == 0
    return read_result(path)


@every_observable
def test_a_finite_number(name, contact, result):
    """Of a contact, and written and shown; dents leave the error of the gap alone without a
    bound."""
    value = all_observables()[name](contact)
    assert as_text(result)
    if name == "gap_bound":
        assert value is None
        assert name not in result.steps[1]
        return
    assert isfinite(value)
    assert value == float(value)
    assert isfinite(result.steps[1][name])
    assert name in as_dict(result)["steps"][1]


@every_observable
def test_alone(name):
    """It stands beside the cheap ones, and no other."""
    surface = rough((1, 8, 2), boundary="free")
    scene = Scene.from_dict(
        {
            "surface": surface,
            "material": HARD,
            "load": {"p_star": [0.05, 0.1]},
            "output": {"observables": [name]},
        }
    )
    steps = run_scene(scene, out="one.h5", quiet=True).steps
    kept = {*default_observables(), *observables_named([name])}
    asked = {*duality.OBSERVABLES} - {"gap_bound"} if name in duality.OBSERVABLES else set()
    assert set(steps[1]) & set(all_observables()) == kept - {*duality.OBSERVABLES} | asked


def test_each_number_of_a_result_is_defined(result, cli):
    """Its meaning and its unit, in the program and on one page."""
    page = cli.prints("help observables --markdown")
    surface = {"unit": "m", "pressure_unit": "Pa"}
    for name in {*result.steps[1], *all_observables()}:
        assert all_numbers()[name][0]
        assert said_of(name, surface, all_numbers())["units"]
        assert f"| `{name}` | " in page
    names = "stiffness", "patch_largest", "a_r", "energy"
    found = [said_of(name, surface, all_numbers())["units"] for name in names]
    assert found == ["Pa/m", "m^2", "1", "Pa m"]


@every_observable
@pytest.mark.parametrize(
    ("surface", "without"),
    [
        (
            {"kind": "wave", "amplitude": 0.0, "n": [4, 4]},
            (
                "kappa",
                "a_r_corrected",
                "kappa_corrected",
                "gap_over_h_rms",
                "gap_over_g_rms_lam_s",
                "stiffness",
                "conductance",
            ),
        ),
        (
            {"kind": "wave", "amplitude": 0.1, "n": [16, 4]},
            ("gap_over_g_rms_lam_s", "a_r_corrected", "kappa_corrected"),
        ),
        (rough((1, 4, 2), g_rms=1e-3), ("stiffness", "conductance")),
    ],
    ids=["flat", "wave", "full contact"],
)
def test_degenerate_contacts(name, surface, without):
    """A number, or None where the quantity does not exist, never NaN, on flat walls, profiles and
    in full contact."""
    made = sweep_of(surface, duality=True)
    for p in (0.05, 0.06):
        value = all_observables()[name](made.solve(p))
        assert value is None if name in (*without, "approach", "a_plastic") else isfinite(value)


def test_unknown_name():
    scene = Scene.from_dict(
        {"surface": FREE, "load": {"p_star": 0.1}, "output": {"observables": ["a_rr"]}}
    )
    with pytest.raises(SceneError, match='nearest: "a_r"'):
        run_scene(scene, quiet=True)


@pytest.mark.parametrize("accuracy", [1e-1, 1e-3])
@pytest.mark.parametrize("p_star", [0.02, 0.2, 1.0])
def test_bounds_hold_without_any_estimate(p_star, accuracy):
    """Of the true errors, and they do not say more than is so by orders of magnitude."""
    exact = sweep_of(rough(), **EXACT).solve(p_star)
    found = sweep_of(rough(), duality=True, accuracy=accuracy).solve(p_star)
    wrong = [
        np.linalg.norm(found.field("pressure")[:] - exact.field("pressure")[:])
        / np.linalg.norm(exact.field("pressure")[:]),
        abs(found.gap_mean / exact.gap_mean - 1),
    ]
    for true, bound in zip(wrong, (duality.pressure_bound(found), duality.gap_bound(found))):
        assert bound is None or true < bound < 300 * accuracy
    assert accuracy > 1e-2 or duality.pressure_bound(found)


def test_duality_gap_only_on_request():
    """It costs half an FFT pair; without it the certificate has all the rest."""
    plain, asked = (
        sweep_of(FREE, duality=wanted, accuracy=1e-3).solve(0.1) for wanted in (False, True)
    )
    assert plain.certificate.duality_gap is None
    assert asked.certificate.duality_gap > 0
    assert asked.fft_pairs == plain.fft_pairs + 0.5
