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


@pytest.mark.parametrize("length", [True, False], ids=["of length", "of pressure"])
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


@pytest.mark.parametrize("p", [1e-40, 1e40])
def test_a_load_that_single_precision_cannot_hold(z, p):
    with refused(r'^solver\.precision: found "single"'):
        hpc_gfmd.solve(z, p, precision="single")
    if p > 1:
        found = hpc_gfmd.solve(z, p)
        assert (found.status, found.precision, found.a_r) == ("converged", "float64", 1.0)
        assert found.pressure.min() == pytest.approx(p)


def test_a_load_at_free_edges_that_coarse_levels_cannot_hold(z):
    """Full contact is not uniform there; up to about the load that is refused it is found, in
    double precision beyond squares."""
    with refused(r"^load: found p\* = .*, allowed: 1e-100 to"):
        hpc_gfmd.solve(z, 1e40, boundary="free")
    with refused(r'^solver\.precision: found "single"'):
        hpc_gfmd.solve(z, 1e20, precision="single", boundary="free")
    found = hpc_gfmd.solve(z, 1e30, boundary="free")
    assert (found.status, found.precision, found.a_r) == ("converged", "float64", 1.0)


@pytest.mark.parametrize(
    "given",
    [
        {"E_star": 1e100, "heights": 1e100, "physical_sizes": (1e-100, 1e-100)},
        {"E_star": 1e-100, "heights": 1e-90, "physical_sizes": (1e90, 1e90)},
        {"E_star": 1e-20, "pressure": 1e90},
    ],
)
def test_units_beyond_double_precision_are_refused(z, given):
    given = {"pressure": 1.0} | given
    with refused(r"allowed: 1e-[12][05]0 to 1e"):
        hpc_gfmd.solve(z / np.abs(z).max() * given.pop("heights", 1.0), **given)


@pytest.mark.parametrize("value", [1.7e308, -1.7e308, 1e101, np.inf, -np.inf, np.nan])
def test_heights_that_instruments_write_for_missing_points(z, value, tmp_path, cli):
    broken = z.copy()
    broken[3, 4] = value
    with refused(r"surface: found .* at \(3, 4\), allowed: finite heights, -1e\+100 to 1e\+100"):
        hpc_gfmd.solve(broken, 0.1)
    np.save("z.npy", broken)
    (tmp_path / "s.toml").write_text(
        '[surface]\nkind = "file"\nphysical_sizes = [1, 1]\npath = "z.npy"\n[load]\np_star = 0.1\n'
    )
    err = cli.refused("run s.toml")
    assert "surface.path" in err
    assert "(3, 4)" in err


def test_heights_that_differ_by_nothing(z):
    with refused("heights that differ by"):
        hpc_gfmd.solve(z * 1e-320, 0.1)
