"""What every distribution promises. A new one in hpc_gfmd/contact is tested by being there."""

import numpy as np
import pytest
from contacts import rough, sweep_of

import hpc_gfmd
from hpc_gfmd.commands.show import as_dict, as_text
from hpc_gfmd.contact import all_distributions
from hpc_gfmd.output.read import read_result
from hpc_gfmd.runs.simulation import run_scene
from hpc_gfmd.scene import Scene
from hpc_gfmd.util.errors import SceneError

every_distribution = pytest.mark.parametrize("name", all_distributions())
ATTRIBUTE_BYTES = 2**16 - 512  # that HDF5 takes


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    path = tmp_path_factory.mktemp("distributions") / "all.h5"
    scene = Scene.from_dict(
        {
            "surface": rough((1, 8, 4)),
            "load": {"p_star": [0.05, 0.1]},
            "output": {"observables": ["a_r"], "distributions": list(all_distributions())},
        }
    )
    assert run_scene(scene, out=path, quiet=True).exit_code == 0
    return read_result(path)


@every_distribution
def test_small_and_finite(name):
    arrays = all_distributions()[name](sweep_of(rough((1, 8, 4)), accuracy=1e-3).solve(0.05))
    for array in arrays.values():
        assert array.ndim == 1
        assert array.nbytes < ATTRIBUTE_BYTES / 8
        assert np.isfinite(array).all()
    x, y = arrays.values()
    assert (np.diff(x) > 0).all()
    assert len(x) - len(y) == ("edges" in arrays)


@every_distribution
def test_written_and_shown(name, result):
    found = {
        key: value
        for key, value in result.steps[1].items()
        if isinstance(value, list) and key.startswith(f"{name}_")
    }
    assert found
    assert found.items() <= as_dict(result)["steps"][1].items()
    assert as_text(result)


@every_distribution
@pytest.mark.parametrize(
    "surface",
    [
        {"kind": "wave", "amplitude": 0.0, "n": [4, 4]},
        {"kind": "wave", "amplitude": 0.1, "n": [16, 4]},
        rough((1, 4, 2), g_rms=1e-3),
    ],
    ids=["flat", "wave", "full contact"],
)
def test_degenerate_contacts(name, surface):
    """Finite numbers, or None where there is nothing to count."""
    arrays = all_distributions()[name](sweep_of(surface).solve(0.05))
    assert arrays is None or all(
        len(array) and np.isfinite(array).all() for array in arrays.values()
    )


def test_one_point():
    found = hpc_gfmd.solve([[1.0]], 0.1, distributions=list(all_distributions())).distributions
    assert {"pressure", "patches", "gap_autocorrelation"} <= found.keys()
    assert "gap" not in found


@pytest.mark.parametrize("boundary", ["free", ["periodic", "free"]], ids=str)
def test_of_surfaces_that_end(boundary):
    """Counts as ever; waves only of periodic surfaces, which is said before anything is solved."""
    scene = {"surface": rough((1, 8, 2), boundary=boundary), "load": {"p_star": 0.1}}
    counts = Scene.from_dict(
        scene
        | {
            "output": {
                "observables": ["patches", "perimeter", "percolation"],
                "distributions": ["pressure", "gap", "patches"],
            }
        }
    )
    (step,) = run_scene(counts, out="x.h5", quiet=True).steps
    assert {
        "patches",
        "perimeter",
        "pressure_density",
        "gap_edges",
        "patches_density",
    } <= step.keys()
    with pytest.raises(
        SceneError,
        match=(
            r"output\.distributions: found 'gap_spectrum'.* allowed: gap, patches, patches_8,"
            r" pressure"
        ),
    ):
        run_scene(
            Scene.from_dict(scene | {"output": {"distributions": ["gap_spectrum"]}}),
            out="y.h5",
            quiet=True,
        )
