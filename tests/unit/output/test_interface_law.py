"""The law of an interface: interpolation, and round trips through files."""

import re
from dataclasses import replace

import numpy as np
import pytest

from hpc_gfmd.commands.law import as_text
from hpc_gfmd.output.interface_law import InterfaceLaw, interpolate
from hpc_gfmd.output.law_files import read_law, write_law
from hpc_gfmd.output.unit_systems import SYSTEMS, converted
from hpc_gfmd.util.errors import SceneError


def power_law(pressures=7):
    """A law whose quantities are powers of the pressure, with a seal that closes at 1e8."""
    p = np.geomspace(1e6, 1e9, pressures)
    values = {
        "a_r": 1e-9 * p,
        "gap_mean": 1e-6 * (1e6 / p) ** 0.3,
        "stiffness": 1e7 * p**0.95,
        "conductance": 1e-4 * p**0.95,
        "critical_gap_x": np.where(p < 0.99e8, 1e-6 * (1e6 / p) ** 0.4, 0.0),
    }
    units = {"a_r": "1", "gap_mean": "m", "stiffness": "Pa/m", "conductance": "1/m"}
    units |= {"critical_gap_x": "m", "pressure": "Pa", "gap_at_touch": "m"}
    errors = {name: np.full(pressures, 0.01) for name in values}
    scatter = {name: 0.1 * v for name, v in values.items()}
    return InterfaceLaw(p, values, errors, scatter, 2e-6, units, 3, ("a wall", "of steel"))


def test_powers_are_interpolated_exactly():
    law = power_law()
    pressures = np.geomspace(1e6, 1e9, 41)
    np.testing.assert_allclose(law("a_r", pressures), 1e-9 * pressures, rtol=1e-12)
    np.testing.assert_allclose(law("conductance", pressures), 1e-4 * pressures**0.95, rtol=1e-12)
    assert isinstance(law("a_r", 2e6), float)


def test_interpolation_is_monotone_and_stops_at_missing_values():
    p = np.array([1.0, 2.0, 4.0, 8.0, 16.0])
    at = np.geomspace(1, 16, 200)
    rising = interpolate(p, np.array([1.0, 1.1, 5.0, 5.2, 6.0]), at)
    assert (np.diff(rising) >= 0).all()
    incomplete = interpolate(p, np.array([1.0, 2.0, 3.0, np.nan, np.nan]), at)
    assert np.isfinite(incomplete[at <= 4]).all()
    assert np.isnan(incomplete[at > 4.01]).all()
    closes = interpolate(p, np.array([3.0, 2.0, 1.0, 0.0, 0.0]), at)
    assert (closes[at < 7.99] >= 1 - 1e-12).all()
    assert (closes[at >= 8.01] == 0).all()


def test_sealing_pressure():
    law = power_law()
    assert law.sealing_pressure("x") == pytest.approx(1e8)
    with pytest.raises(SceneError, match="axis"):
        law.sealing_pressure("y")
    law.values["critical_gap_x"][:] = 1e-6
    with pytest.raises(SceneError, match="open"):
        law.sealing_pressure("x")


def test_a_seal_that_is_tight_on_this_grid_says_what_the_grid_leaves_open():
    law = power_law()
    law.errors["critical_gap_x"][law.values["critical_gap_x"] == 0] = np.inf
    *_, closed, tight = as_text(law).splitlines()
    assert closed.endswith("0 +- ?")
    leaks = law.pressure[law.pressure < 0.99e8][-1]
    bar = 0.01 * 1e-6 * (1e6 / leaks) ** 0.4
    assert tight.endswith(f"on this grid: critical gaps are within {bar:.2g} m")


def test_a_law_is_not_extrapolated():
    for pressure in (0.5e6, 2e9, np.nan):
        with pytest.raises(SceneError, match=r"allowed: 1e\+06 to 1e\+09"):
            power_law()("a_r", pressure)
    with pytest.raises(SceneError, match="gap"):
        power_law()("gap", 1e7)


def test_csv_round_trip_is_exact(tmp_path):
    law = power_law()
    law.values["stiffness"][-1] = np.nan
    back = read_law(write_law(law, tmp_path / "law.csv"))
    np.testing.assert_array_equal(back.pressure, law.pressure)
    for name, values in law.values.items():
        np.testing.assert_array_equal(back.values[name], values)
        np.testing.assert_array_equal(back.errors[name], law.errors[name])
        np.testing.assert_array_equal(back.scatter[name], law.scatter[name])
    assert (back.units, back.gap_at_touch, back.surfaces) == (law.units, 2e-6, 3)
    assert back.about == law.about


def test_finite_element_file_holds_closure_and_conductance(tmp_path):
    """The rows of *SURFACE BEHAVIOR and *GAP CONDUCTANCE, both from the origin."""
    law = power_law()
    path = write_law(law, tmp_path / "law.inp", conductivity=(50.0, 200.0))
    _, behaviour, conductance = re.split(
        r"^\*[A-Z].*BEHAVIOR.*$|^\*GAP.*$", path.read_text(), flags=re.M
    )
    closure = np.loadtxt(behaviour.splitlines(), delimiter=",")
    heat = np.loadtxt(conductance.splitlines(), delimiter=",")
    assert not closure[0].any()
    assert not heat[0].any()
    p = np.clip(closure[1:, 0], *law.pressure[[0, -1]])
    np.testing.assert_allclose(closure[1:, 1], law.gap_at_touch - law("gap_mean", p), rtol=1e-6)
    np.testing.assert_allclose(heat[1:, 0], 80.0 * law("conductance", p), rtol=1e-6)
    np.testing.assert_allclose(heat[:, 1], closure[:, 0])
    assert "** of steel\n** gap_at_touch = 2e-06 m\n" in path.read_text()


def test_what_cannot_be_written_leaves_no_file(tmp_path):
    """Other arguments that are refused are in tests/unit/commands/test_law.py."""
    law = power_law()
    with pytest.raises(SceneError, match="conductivity"):
        write_law(law, tmp_path / "law.inp", conductivity=(1.0, 2.0, 3.0))
    law.values["gap_mean"][:] = 0.0
    with pytest.raises(SceneError, match="rough"):
        write_law(replace(law, gap_at_touch=0.0), tmp_path / "law.inp")
    assert not list(tmp_path.iterdir())


def test_foreign_files_are_refused(tmp_path):
    path = tmp_path / "law.csv"
    for text in ("", "a,b\n1,2\n", "pressure [Pa]\n1\n"):
        path.write_text(text)
        with pytest.raises(SceneError, match="law"):
            read_law(path)
    with pytest.raises(SceneError, match=r"allowed: a \.csv"):
        read_law(tmp_path / "law.inp")


def test_products_of_units_are_converted():
    systems = [SYSTEMS[name] for name in ("SI", "um-uN-MPa")]
    assert converted("Pa m", *systems) == (1.0, "MPa um")
    assert converted("1/m^2", *systems) == (1e-12, "1/um^2")
    assert converted("1", *systems) == (1.0, "1")


def test_units_of_finite_element_programs(tmp_path):
    """A law in mm, N, MPa has the same meaning, in its file, too; the way back is exact."""
    law = power_law()
    in_mm = law.in_units("mm-N-MPa")
    assert in_mm.units == {
        "a_r": "1",
        "gap_mean": "mm",
        "stiffness": "MPa/mm",
        "conductance": "1/mm",
        "critical_gap_x": "mm",
        "pressure": "MPa",
        "gap_at_touch": "mm",
    }
    assert in_mm("stiffness", 20.0) == pytest.approx(law("stiffness", 20e6) * 1e-9)
    back = read_law(write_law(in_mm, tmp_path / "law.csv")).in_units("SI")
    for name, values in law.values.items():
        np.testing.assert_allclose(back.values[name], values, rtol=1e-14)
    assert back.gap_at_touch == pytest.approx(law.gap_at_touch)
    for name, per_si in (("SI", 1.0), ("mm-N-MPa", 1e-3), ("um-uN-MPa", 1.0)):
        path = write_law(law.in_units(name), tmp_path / "law.inp", conductivity=100.0)
        head, _, rows = path.read_text().partition("*GAP CONDUCTANCE, PRESSURE\n")
        assert head.splitlines()[1].startswith("** units: ")
        assert "** conductivity = 100.0 W/(m.K)\n" in head
        last = float(rows.splitlines()[-1].split(",")[0])
        assert last == pytest.approx(100.0 * law.values["conductance"][-1] * per_si)
    with pytest.raises(SceneError, match="units: found 'cgs', allowed: SI"):
        law.in_units("cgs")
    with pytest.raises(SceneError, match="law without units"):
        replace(law, units=dict.fromkeys(law.units, "")).in_units("SI")
