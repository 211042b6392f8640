"""Very large and very small units: fields keep their accuracy, or the scene is refused."""

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
    solution = hpc_gfmd.solve(z, 0.1, accuracy=1e-2)
    assert [getattr(solution, name).dtype for name in FIELDS] == [np.float32] * 3
    return solution


def assert_close(field, wanted, unit):
    """Compare a field, divided by its unit, with the wanted one."""
    np.testing.assert_allclose(
        field.astype(float) / unit, wanted, rtol=1e-5, atol=1e-6 * np.abs(wanted).max()
    )


@pytest.mark.parametrize("length", [True, False])
@pytest.mark.parametrize("unit", UNITS)
def test_solutions_do_not_depend_on_units(z, plain, unit, length):
    L, p = (unit, 1) if length else (1, unit)
    solution = hpc_gfmd.solve(L * z, 0.1 * p, E_star=p, physical_sizes=(L, L), accuracy=1e-2)
    assert (solution.status, solution.precision) == ("converged", "float32")
    assert length or solution.a_r == plain.a_r
    for name in ("gap", "displacement") if length else ("pressure",):
        assert_close(getattr(solution, name), getattr(plain, name), unit)


def scene(unit, length=1.0, **output):
    """A Scene with E* = unit and cell size `length`; output: keys of [output]."""
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
def test_single_precision_is_refused_where_its_range_is_too_small(tmp_path, unit, length, name):
    with refused(rf'^output\.dtype: found "single".* {name} .*allowed: "double"$'):
        run_scene(scene(unit, length, dtype="single"), out="a.h5", quiet=True)
    assert list(tmp_path.iterdir()) == []
    assert run_scene(scene(unit, length, dtype="double"), out="a.h5", quiet=True).exit_code == 0


@pytest.mark.parametrize(("p", "boundary"), [(1e40, "periodic"), (1e30, "free")])
def test_loads_beyond_single_precision(z, p, boundary):
    """They are solved in double precision; pressures of full contact vary at free edges."""
    solution = hpc_gfmd.solve(z, p, boundary=boundary)
    assert (solution.status, solution.precision, solution.a_r) == ("converged", "float64", 1.0)
    assert boundary == "free" or solution.pressure.min() == pytest.approx(p)
