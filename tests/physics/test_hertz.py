"""Hertz's contact in a large periodic cell, a_c^3 = 3 R F/(4 E*)."""

from math import pi, sqrt

import numpy as np
import pytest
from contacts import EXACT, field, sweep_of

import hpc_gfmd
from hpc_gfmd.contact import all_observables
from hpc_gfmd.theory.elastic import Hertz


@pytest.mark.parametrize(
    ("R", "E_star", "L", "share"),
    [(1.0, 1.0, 1.0, 0.05), (30.0, 2e9, 1e-3, 0.05), (1.0, 1.0, 1.0, 0.08)],
)
def test_hertz(R, E_star, L, share):
    a_c = share * L
    p0 = 4 * E_star * a_c**3 / (3 * R) / L**2
    sweep = sweep_of(
        {"kind": "sphere", "radius": R, "n": [256, 256], "physical_sizes": [L, L]}, E_star, **EXACT
    )
    step = sweep.solve(p0)
    exact = Hertz(R, p0 * L**2, E_star)
    assert sqrt(all_observables()["a_r"](step) * L**2 / pi) == pytest.approx(exact.a, rel=3e-3)
    p = field(step, "pressure")
    assert p.max() == pytest.approx(exact.peak_pressure, rel=1e-3)
    assert np.mean(p) == pytest.approx(p0, rel=1e-9)
    # profile
    x = (np.arange(256) - 128) / 256 * L
    r2 = x[:, None] ** 2 + x**2
    inside = r2 < (0.8 * a_c) ** 2
    assert np.abs(p[inside] / exact.pressure(np.sqrt(r2[inside])) - 1).max() < 0.02


def test_the_peak_is_the_contact():
    """Peaks point up: a bump touches at its top, a dent does not touch at its bottom."""
    x = (np.arange(32) - 16) / 32
    bump = np.exp(-20 * (x[:, None] ** 2 + x**2))
    up, down = (hpc_gfmd.solve(z, 1e-2) for z in (bump, -bump))
    assert up.pressure[16, 16] == up.pressure.max() > 0
    assert down.pressure[16, 16] == 0
