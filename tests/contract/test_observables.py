"""The contract of observables and distributions; new files in hpc_gfmd/contact are tested
automatically."""

from math import isfinite

import numpy as np
import pytest
from contacts import EXACT, rough, sweep_of

from hpc_gfmd.commands.show import as_dict, as_text
from hpc_gfmd.contact import (
    all_distributions,
    all_numbers,
    all_observables,
    default_observables,
    observables_named,
    response,
)
from hpc_gfmd.output.numbers import dataset_attributes
from hpc_gfmd.output.read import read_result
from hpc_gfmd.runs.simulation import run_scene
from hpc_gfmd.scene import Scene

every_observable = pytest.mark.parametrize("name", all_observables())
every_distribution = pytest.mark.parametrize("name", all_distributions())
ATTRIBUTE_BYTES = 2**16 - 512  # limit of HDF5
# FREE with HARD has all observables but MISSING, PERIODIC all distributions
OF_ATTRACTION = {"attraction", "separation_work", "stability", "stickiness"}
OF_ATTRACTION |= {"unique", "a_r_other_branch"}
MISSING = {"gap_bound"} | OF_ATTRACTION
FREE = rough((1, 8, 4), boundary="free")
HARD = {"hardness": 0.5}
PERIODIC = rough((1, 8, 4))
DEGENERATE = {
    "flat": {"kind": "wave", "amplitude": 0.0, "n": [4, 4]},
    "wave": {"kind": "wave", "amplitude": 0.1, "n": [16, 4]},
    "full contact": rough((1, 4, 2), g_rms=1e-3),
}
WITHOUT = {
    "flat": """a_plastic dent_mean dissipated_work approach kappa a_r_corrected kappa_corrected
        gap_over_h_rms gap_over_g_rms_lam_s stiffness conductance""",
    "wave": """a_plastic dent_mean dissipated_work approach gap_over_g_rms_lam_s a_r_corrected
        kappa_corrected""",
    "full contact": "a_plastic dent_mean dissipated_work approach stiffness conductance",
}


def run(surface, output, out="x.h5", loads=(0.05, 0.1), material=()):
    """The Solutions of a scene with this [output]."""
    tables = {"surface": surface, "material": dict(material), "load": {"p_star": list(loads)}}
    return run_scene(Scene.from_dict(tables | {"output": output}), out=out, quiet=True)


@pytest.fixture(scope="module")
def contact():
    made = sweep_of(FREE, duality=True, layer=HARD, accuracy=1e-3)
    made.solve(0.05)
    return made.solve(0.1)


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Results with all observables, and with all distributions."""
    folder = tmp_path_factory.mktemp("observables")
    everything = {"observables": list(all_observables())}
    assert run(FREE, everything, folder / "numbers.h5", material=HARD).exit_code == 0
    everything = {"observables": ["a_r"], "distributions": list(all_distributions())}
    assert run(PERIODIC, everything, folder / "arrays.h5").exit_code == 0
    return [read_result(folder / name) for name in ("numbers.h5", "arrays.h5")]


def require_numbers(contact, missing):
    """Require a finite number of every observable but the missing ones, which are None."""
    for name, observable in all_observables().items():
        value = observable(contact)
        assert value is None if name in missing else isfinite(value), name
        assert value is None or value == float(value), name


def test_observables_are_finite_numbers(contact):
    """Dents exclude a bound of the gap; adhesive observables need adhesion."""
    require_numbers(contact, MISSING)


@every_distribution
def test_distributions_are_small_and_finite(name):
    arrays = all_distributions()[name](sweep_of(PERIODIC, accuracy=1e-3).solve(0.05))
    for array in arrays.values():
        assert array.ndim == 1
        assert array.nbytes < ATTRIBUTE_BYTES / 8
        assert np.isfinite(array).all()
    x, y = arrays.values()
    assert (np.diff(x) > 0).all()
    assert len(x) - len(y) == ("edges" in arrays)


def test_written_and_shown(results):
    numbers, arrays = (result.steps[1] for result in results)
    assert all(isfinite(numbers[name]) for name in all_observables().keys() - MISSING)
    assert set(all_distributions()) <= {
        key.rpartition("_")[0] for key, value in arrays.items() if isinstance(value, list)
    }
    for result in results:
        assert result.steps[1].items() <= as_dict(result)["steps"][1].items()
        assert as_text(result)


@every_observable
def test_single_observables_add_no_others(name):
    """Steps hold the requested observable beside the default ones."""
    (_, step) = run(rough((1, 8, 2), boundary="free"), {"observables": [name]}, material=HARD).steps
    cheap = {*default_observables(), *observables_named([name])}
    duality_observables = {*response.DUALITY} - {"gap_bound"} if name in response.DUALITY else set()
    assert (
        set(step) & set(all_observables())
        == cheap - {*response.DUALITY} - OF_ATTRACTION | duality_observables
    )


def test_every_number_has_a_definition_and_a_unit(results, cli):
    """In the package and on the page of `help observables`."""
    page = cli.prints("help observables --markdown")
    surface = {"unit": "m", "pressure_unit": "Pa"}
    for name in {*results[0].steps[1], *all_observables()}:
        assert all_numbers()[name][0]
        assert dataset_attributes(name, surface, all_numbers())["units"]
        assert f"| `{name}` | " in page
    names = "stiffness", "patch_largest", "a_r", "energy"
    units = [dataset_attributes(name, surface, all_numbers())["units"] for name in names]
    assert units == ["Pa/m", "m^2", "1", "Pa m"]


@pytest.mark.parametrize("case", DEGENERATE)
def test_degenerate_contacts(case):
    """Flat walls, profiles and full contact give numbers or None, never NaN."""
    made = sweep_of(DEGENERATE[case], duality=True)
    missing = OF_ATTRACTION.union(WITHOUT[case].split())
    for p in (0.05, 0.06):
        require_numbers(made.solve(p), missing)


def test_observables_with_adhesion():
    """Finite numbers, except where only the convex problem has one; None without contact."""
    wall = rough((1, 8, 4), g_rms=1.0)
    adhesion = {"adhesion": {"work": 0.002, "range": 0.02}}
    made = sweep_of(wall, duality=True, layer=adhesion, accuracy=1e-3)
    missing = {"a_plastic", "dent_mean", "dissipated_work"}
    missing |= {"approach", "stiffness", "gap_bound", "pressure_bound"}
    missing |= {"unique", "a_r_other_branch"}  # load.unique
    require_numbers(made.solve(0.05), missing)
    apart = made.solve(-0.05)
    for name, observable in all_observables().items():
        value = observable(apart)
        assert value is None or isfinite(value), name


@every_distribution
@pytest.mark.parametrize("case", DEGENERATE)
def test_degenerate_distributions(name, case):
    """Finite numbers, or None without anything to count."""
    arrays = all_distributions()[name](sweep_of(DEGENERATE[case]).solve(0.05))
    assert arrays is None or all(
        len(array) and np.isfinite(array).all() for array in arrays.values()
    )


@pytest.mark.parametrize("accuracy", [1e-1, 1e-3])
@pytest.mark.parametrize("p_star", [0.02, 0.2, 1.0])
def test_bounds_of_true_errors(p_star, accuracy):
    """Bounds by the duality gap hold, and are not larger by orders of magnitude."""
    exact = sweep_of(rough(), **EXACT).solve(p_star)
    solved = sweep_of(rough(), duality=True, accuracy=accuracy).solve(p_star)
    errors = [
        np.linalg.norm(solved.field("pressure")[:] - exact.field("pressure")[:])
        / np.linalg.norm(exact.field("pressure")[:]),
        abs(solved.gap_mean / exact.gap_mean - 1),
    ]
    for error, bound in zip(errors, (response.pressure_bound(solved), response.gap_bound(solved))):
        assert bound is None or error < bound < 300 * accuracy
    assert accuracy > 1e-2 or response.pressure_bound(solved)


def test_duality_gap_only_on_request():
    """It costs half an FFT pair."""
    plain, with_duality = (
        sweep_of(FREE, duality=requested, accuracy=1e-3).solve(0.2) for requested in (False, True)
    )
    assert plain.certificate.duality_gap is None
    assert with_duality.certificate.duality_gap > 0
    assert with_duality.fft_pairs == plain.fft_pairs + 0.5
