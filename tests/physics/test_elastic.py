"""Closed-form elastic solutions: known numbers, the energy relation, limits."""

import numpy as np
import pytest
from scipy.integrate import quad

from hpc_gfmd.theory.elastic import KAPPA_BGT, Hertz, Westergaard
from hpc_gfmd.util.errors import SceneError


def test_constant():
    assert pytest.approx(2.50662827) == KAPPA_BGT


def test_hertz():
    hertz = Hertz(R=2.0, F=0.3, E_star=1.7)
    assert hertz.a**3 == pytest.approx(3 * 2.0 * 0.3 / (4 * 1.7))
    assert hertz.peak_pressure == pytest.approx(3 * 0.3 / (2 * np.pi * hertz.a**2))
    force = quad(lambda r: 2 * np.pi * r * hertz.pressure(r), 0, hertz.a)[0]
    assert force == pytest.approx(0.3, rel=1e-8)
    assert hertz.approach == pytest.approx(hertz.a**2 / 2)
    assert hertz.pressure(2 * hertz.a) == 0


def test_westergaard_numbers():
    a = 0.3
    length = 2.0
    e_star = 1.5
    full = np.pi * e_star * a / length
    for share in (0.01, 0.25, 0.7, 0.999):
        wave = Westergaard(share * full, a, length, e_star)
        assert wave.p_full == pytest.approx(full)
        assert wave.a_r == pytest.approx(2 / np.pi * np.arcsin(np.sqrt(share)))
        # the contact reaches to a_r L/2 on either side
        mean = quad(wave.pressure, -wave.a_r, wave.a_r, epsabs=1e-10)[0] / length
        assert mean == pytest.approx(share * full, rel=1e-7)
        assert wave.pressure(0) == pytest.approx(wave.peak_pressure)
        assert wave.peak_pressure == pytest.approx(2 * np.sqrt(share) * full)
    assert Westergaard(0.25 * np.pi).a_r == pytest.approx(1 / 3)


def test_westergaard_energy_relation():
    """dU = -p d(gap), the compliance is -d(gap)/dp, and full contact stores E* A^2 pi/(4 L)."""
    p = np.linspace(1e-3, 1.4, 400) * np.pi
    wave = Westergaard(p)
    d = 1e-6
    slope = (Westergaard(p + d).gap_mean - Westergaard(p - d).gap_mean) / (2 * d)
    energy = (Westergaard(p + d).energy - Westergaard(p - d).energy) / (2 * d)
    np.testing.assert_allclose(energy, -p * slope, atol=1e-8)
    np.testing.assert_allclose(wave.compliance, -slope, atol=1e-6)
    assert wave.energy[-1] == pytest.approx(np.pi / 4)
    assert wave.gap_mean[-1] == 0
    assert wave.a_r[-1] == 1


def test_westergaard_without_load_and_beyond_full_contact():
    free = Westergaard(0.0)
    closed = Westergaard(5.0)
    assert (free.a_r, free.gap_mean, free.energy, free.peak_pressure) == (0, 1, 0, 0)
    assert free.compliance == np.inf
    assert (closed.a_r, closed.gap_mean, closed.compliance) == (1, 0, 0)
    assert closed.peak_pressure == pytest.approx(5 + np.pi)
    assert closed.pressure(0.5) == pytest.approx(5 - np.pi)


def test_refused():
    for make in (lambda: Hertz(-1, 1), lambda: Westergaard(np.nan), lambda: Westergaard(1, 0)):
        with pytest.raises(SceneError, match=r"found .*allowed"):
            make()
