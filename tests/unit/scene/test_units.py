"""Numbers of any size: they survive in the fields that come back and are stored, or the scene is
refused."""

import numpy as np
import pytest
from contacts import heights_of, rough
from refusal import refused

import hpc_gfmd
from hpc_gfmd.runs.simulation import run_scene
from hpc_gfmd.scene import Scene

FIELDS = ("pressure", "gap", "displacement")
UNITS = [1e-90, 1e-45, 1e-38, 1e-31, 1e31, 1e38, 1e45, 1e90]
ROUGH = rough()


@pytest.fixture(scope="module")
def z():
    return heights_of(ROUGH)


@pytest.fixture(scope="module")
def plain(z):
    found = hpc_gfmd.solve(z, 0.1, accuracy=1e-2)
    assert [getattr(found, name).dtype for name in FIELDS] == [np.float32] * 3
    return found


def close(found, wanted, unit):
    np.testing.assert_allclose(
        found.astype(float) / unit, wanted, rtol=1e-5, atol=1e-6 * np.abs(wanted).max()
    )


@pytest.mark.parametrize("length", [True, False])
@pytest.mark.parametrize("unit", UNITS)
def test_any_unit(z, plain, unit, length):
    L, p = (unit, 1) if length else (1, unit)
    found = hpc_gfmd.solve(L * z, 0.1 * p, E_star=p, physical_sizes=(L, L), accuracy=1e-2)
    assert (found.status, found.precision) == ("converged", "float32")
    assert length or found.a_r == plain.a_r
    for name in ("gap", "displacement") if length else ("pressure",):
        close(getattr(found, name), getattr(plain, name), unit)


def scene(unit, length=1.0, **output):
    return Scene.from_dict(
        {
            "surface": ROUGH | {"physical_sizes": [length, length]},
            "material": {"E_star": unit},
            "load": {"p_star": [0.1]},
            "solver": {"accuracy": 1e-2},
            "output": {"fields": list(FIELDS)} | output,
        }
    )


@pytest.mark.parametrize(
    ("unit", "length", "name"),
    [(1e-40, 1, "pressure"), (1e40, 1, "pressure"), (1, 1e-40, "gap"), (1, 1e40, "gap")],
)
def test_single_precision_that_is_insisted_on_is_refused_where_it_is_too_little(
    tmp_path, unit, length, name
):
    with refused(
        rf'^output\.dtype: found "single", which cannot hold the {name} .*allowed: "double"$'
    ):
        run_scene(scene(unit, length, dtype="single"), out="a.h5", quiet=True)
    assert list(tmp_path.iterdir()) == []
    assert run_scene(scene(unit, length, dtype="double"), out="a.h5", quiet=True).exit_code == 0


@pytest.mark.parametrize(("p", "boundary"), [(1e40, "periodic"), (1e30, "free")])
def test_a_load_that_single_precision_cannot_hold(z, p, boundary):
    """Full contact is not uniform at free edges; up to about the load that is refused it is found,
    in double precision beyond squares."""
    found = hpc_gfmd.solve(z, p, boundary=boundary)
    assert (found.status, found.precision, found.a_r) == ("converged", "float64", 1.0)
    assert boundary == "free" or found.pressure.min() == pytest.approx(p)
