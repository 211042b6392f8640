"""Leak rates of parallel plates and of rough seals from leaking to tight."""

import numpy as np
import pytest
from contacts import rough_wall
from refusal import refused

import hpc_gfmd
from hpc_gfmd.theory.leak import leak_rate
from hpc_gfmd.util.errors import SceneError


def test_square_plates():
    """A gap of 1 um, water, 1 bar: g^3 dp/(12 eta)."""
    assert leak_rate(1e-6, 1e-3, 1e5) == pytest.approx(1e-18 * 1e5 / 12e-3)
    assert leak_rate(1e-6, 1e-3, 1e5, width=0.3, length=0.1) == pytest.approx(2.5e-11)


def test_numbers_out_of_range_are_refused():
    for name, value in [("viscosity", 0.0), ("pressure_drop", -1.0), ("width", 0.0)]:
        arguments = {"viscosity": 1e-3, "pressure_drop": 1e5, "width": 1.0, "length": 1.0}
        arguments[name] = value
        with pytest.raises(SceneError, match=name):
            leak_rate(1e-6, **arguments)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("p_star", [0.05, 0.1, 0.15])
def test_errors_contain_the_rate_of_a_finer_grid(seed, p_star):
    coarse, fine = (
        hpc_gfmd.solve(rough_wall((2, 8, waves), seed=seed), p_star=p_star) for waves in (8, 32)
    )
    for axis in "xy":
        rates = [solution.leak_rate(1e-3, 1e5, axis=axis) for solution in (coarse, fine)]
        errors = [solution.leak_rate_error(axis) for solution in (coarse, fine)]
        allowed = sum(rate * error for rate, error in zip(rates, errors) if rate > 0)
        assert abs(rates[0] - rates[1]) < allowed or min(rates) == 0


def test_the_width_of_a_profile_is_no_error():
    z = 1e-6 * np.cos(2 * np.pi * (np.arange(16) + 0.5) / 16)[None]
    errors = [
        hpc_gfmd.solve(
            z, "1 MPa", "10 GPa", physical_sizes=(width, "1 mm"), boundary="periodic"
        ).leak_rate_error()
        for width in ("1 um", "1 mm")
    ]
    assert errors[0] == pytest.approx(errors[1])


def test_a_seal_leaks_less_with_load_and_closes():
    wall = rough_wall((2, 8, 4))
    loads = hpc_gfmd.solve(wall, p_star=[0.02, 0.1, 0.6])
    rates = loads.leak_rate(1e-3, 1e5)
    assert (np.diff(rates) < 0).all()
    assert rates[-1] == 0
    critical = loads[0].value("critical_gap_y")
    expected = 3 * critical**3 * 1e5 / 12e-3
    assert loads[0].leak_rate(1e-3, 1e5, width=3.0, length=1.0, axis="y") == pytest.approx(expected)
    for viscosity in ("1 mPa s", "1 mPa*s", "1e-3 N s/m^2", "1 cP"):
        in_units = loads[0].leak_rate(viscosity, "1 bar", width="30 cm", length="10 cm", axis="y")
        assert in_units == pytest.approx(expected)
    first, _, last = loads.leak_rate_error()
    gap_error = loads[0].gap_error + loads[0].value("gap_discretisation")
    of_grid = 0.3 * loads.g_rms * loads.sizes[0] / wall.heights.shape[0]
    assert first == pytest.approx(
        3 * (gap_error * loads[0].gap_mean + of_grid) / loads[0].value("critical_gap_x")
    )
    assert last == np.inf
    with pytest.raises(SceneError, match=r"pressure_drop: found '1 mm', .* length, not of"):
        loads.leak_rate(1e-3, "1 mm")
    with pytest.raises(SceneError, match=r"viscosity: found '1 mPa', .* pressure, not of"):
        loads.leak_rate("1 mPa", "1 bar")
    for extents in ({"width": "30 cm"}, {"width": 30}, {"length": "1 mm"}):
        with refused("width, length: found a (width|length) alone"):
            loads.leak_rate(1e-3, 1e5, **extents)
    for extents in ({"width": 30, "length": "1 mm"}, {"width": "30 cm", "length": 1.0}):
        with refused("width, length: found .* and .*, allowed: both with units or both plain"):
            loads.leak_rate(1e-3, 1e5, **extents)
    with pytest.raises(SceneError, match="axis"):
        loads.leak_rate(1e-3, 1e5, axis="z")
