"""Persson's theory against published numbers, independent quadrature, limits and itself."""

from functools import partial

import numpy as np
import pytest
from numpy.testing import assert_allclose
from refusal import refused
from scene_tables import rows
from scipy.integrate import quad, trapezoid
from scipy.special import erf

from hpc_gfmd.theory import persson, yielding
from hpc_gfmd.theory.slope_profile import SlopeProfile

# gap/h_rms: printed (gamma = 0.42), corrected (gamma = 0.42), original theory (gamma = 1)
TABLE = """
H   | p_star | 1/eps_f | printed | corrected | original
0.3 | 0.007  | 256     | 1.12213 | 1.4593    | 1.86896
0.3 | 0.353  | 256     | 0.02699 | 0.04281   | 0.0266
0.5 | 0.007  | 1024    | 0.85469 | 1.14615   | 1.341
0.8 | 0.007  | 256     | 1.29557 | 1.63728   | 2.2711
0.8 | 0.353  | 256     | 0.01652 | 0.02665   | 0.01519
"""


def energy_sum(p, hurst, eps_f, gamma):
    """Elastic energy in units of E* g_rms h_rms by quadrature of eq. elasticEnergy."""
    norm_h = quad(lambda y: np.exp(-2 * hurst * y), 0, -np.log(eps_f))[0]
    norm_g = quad(lambda y: np.exp((2 - 2 * hurst) * y), 0, -np.log(eps_f))[0]

    def mode(y):
        share = y if hurst == 1 else np.expm1((2 - 2 * hurst) * y) / (2 - 2 * hurst)
        a = erf(np.sqrt(2) * p / np.sqrt(share / norm_g)) if y > 0 else 1.0
        return np.exp((1 - 2 * hurst) * y) * a * (gamma + (1 - gamma) * a * a)

    total = quad(mode, 0, -np.log(eps_f), epsabs=0, epsrel=1e-11, limit=400)[0]
    return total / 4 / np.sqrt(norm_g * norm_h)


def test_published_gaps():
    for row in rows(TABLE)[1:]:
        hurst, p_star, lam, printed, corrected, original = map(float, row)
        gap = partial(persson.mean_gap, p_star, hurst, 1 / lam)
        assert gap(printed=True) == pytest.approx(printed, abs=6e-6)
        assert gap() == pytest.approx(corrected, abs=6e-6)
        assert gap(gamma=1) == pytest.approx(original, abs=6e-6)
        assert gap(gamma=1, printed=True) == gap(gamma=1)


@pytest.mark.parametrize("gamma", [0.42, 1, 0])
def test_stiffness_and_energy_follow_from_the_gap(gamma):
    p = np.geomspace(1e-3, 1.5, 9)
    d = 1e-4

    def change(f):
        return (f(p * (1 + d)) - f(p * (1 - d))) / (2 * d * p)

    slope = change(lambda p: persson.mean_gap(p, 0.6, 1e-3, gamma))
    assert_allclose(
        change(lambda p: persson.elastic_energy(p, 0.6, 1e-3, gamma)), -p * slope, rtol=1e-5
    )
    assert_allclose(persson.stiffness(p, 0.6, 1e-3, gamma), -1 / slope, rtol=1e-6)
    printed = change(lambda p: persson.mean_gap(p, 0.6, 1e-3, gamma, printed=True))
    assert_allclose(persson.stiffness(p, 0.6, 1e-3, gamma, printed=True), -1 / printed, rtol=1e-6)
    for hurst, eps_f in ((0.6, 1e-3), (0, 1 / 16), (1, 1e-3)):
        assert persson.elastic_energy(0.1, hurst, eps_f, gamma) == pytest.approx(
            energy_sum(0.1, hurst, eps_f, gamma), rel=1e-9
        )


def test_hurst_limits_are_continuous():
    p = np.array([0.007, 0.1, 0.353])
    for unit in ("h_rms", "g_rms_lam_s"):
        for eps_f in (1.0, 0.1, 1e-3, 1e-20):
            for f in (persson.mean_gap, persson.stiffness):
                for end, near in ((0, 1e-9), (1, 1 - 1e-9)):
                    assert_allclose(
                        f(p, end, eps_f, unit=unit), f(p, near, eps_f, unit=unit), rtol=1e-6
                    )


def test_fractal_limit():
    """For eps_f -> 0, gap/(g_rms lam_s) converges and gap/h_rms vanishes, both smoothly."""
    eps_f = np.geomspace(1e-20, 1, 81)
    for hurst in (0, 0.3, 0.5, 0.8, 1):
        gap = np.array([persson.mean_gap(0.353, hurst, e) for e in eps_f])
        assert np.all(gap > 0)
        assert np.all(np.diff(gap) > 0)
        assert np.all(np.abs(np.diff(np.log(gap), 2)) < 0.2)
    lam = [persson.mean_gap(0.353, 0.3, e, unit="g_rms_lam_s") for e in (1e-18, 1e-20)]
    assert lam[0] == pytest.approx(lam[1], rel=1e-8)
    assert persson.mean_gap(0.353, 0.8, 1e-20) < 1e-10


def test_low_pressure():
    """kappa -> sqrt(8/pi), gap ~ -ln p (gamma > 0), stiffness ~ p, without overflow."""
    p = np.array([1e-300, 1e-100, 1e-12, 1e-9])
    assert_allclose(persson.kappa(np.append(p, 0)), np.sqrt(8 / np.pi), rtol=1e-12)
    gap = persson.mean_gap(p, 0.8, 1e-3)
    decay = np.diff(gap) / -np.diff(np.log(p))
    assert_allclose(decay, decay[0], rtol=1e-6)
    assert_allclose(persson.stiffness(p, 0.8, 1e-3)[1:], p[1:] / decay[0], rtol=1e-6)
    assert persson.mean_gap(0.0, 0.8, 1e-3) == np.inf
    assert persson.stiffness(0.0, 0.8, 1e-3) == 0
    assert persson.elastic_energy(0.0, 0.8, 1e-3) == 0


def test_high_pressure():
    p = np.array([1.0, 3, 10, 18, 25, 1e3, 1e200])
    with np.errstate(all="raise", under="ignore"):
        gap = persson.mean_gap(p, 0.5, 1e-3)
        energy = persson.elastic_energy(p, 0.5, 1e-3)
    assert np.all(np.isfinite(gap))
    assert np.all(np.diff(gap[:4]) < 0)
    assert np.all(gap[4:] == 0)
    assert persson.stiffness(1e200, 0.5, 1e-3) == np.inf
    assert_allclose(energy[2:], energy_sum(1e3, 0.5, 1e-3, 0.42), rtol=1e-10)
    assert persson.noncontact_area(4.0) == pytest.approx(1.5417e-15, rel=1e-3)


@pytest.mark.parametrize("hardness", [0.11, 0.3, 3.0, 1e5])
def test_pressure_distribution_with_a_hardness(hardness):
    """Contact and yielded area carry the load; a large hardness gives the elastic theory."""
    p = np.linspace(0, min(hardness, 6.0), 100001)
    density = yielding.pressure_distribution(p, 0.1, hardness)
    area, yielded = yielding.areas(0.1, hardness)
    assert trapezoid(density, p) + yielded == pytest.approx(area, abs=1e-8)
    assert trapezoid(density * p, p) + hardness * yielded == pytest.approx(0.1, rel=1e-8)
    if hardness > 1:
        assert area == pytest.approx(persson.contact_area(0.1), rel=1e-6)
        assert density == pytest.approx(persson.pressure_distribution(p, 0.1), abs=1e-6)
    with refused("below the hardness"):
        yielding.areas(hardness, hardness)


def test_pressure_distribution():
    for p0, scale in ((1e-4, 1.0), (0.1, 1.0), (0.5, 3.0), (40.0, 1.0)):
        p = np.linspace(max(0, p0 - 6 * scale), p0 + 6 * scale, 200001)
        density = persson.pressure_distribution(p, p0, g_rms=scale)
        assert trapezoid(density, p) == pytest.approx(persson.contact_area(p0 / scale), rel=1e-6)
        assert trapezoid(density * p, p) == pytest.approx(p0, rel=1e-6)
    assert persson.pressure_distribution([-1.0, 0.0, 1e200], 0.1).tolist() == [0, 0, 0]


@pytest.mark.parametrize("hurst", [0, 0.3, 0.8, 1])
def test_spectrum_reproduces_the_self_affine_surface(hurst):
    p = np.geomspace(1e-3, 3, 8)
    eps_f = 1 / 200
    q_l = 3.0
    q = np.geomspace(q_l, q_l / eps_f, 11)
    spectrum = 0.7 * q ** (-2 - 2 * hurst)
    profile = SlopeProfile.from_spectrum(q, spectrum, area=2.5)
    p0 = p * 5 * profile.g_rms
    gap = persson.mean_gap(p, hurst, eps_f) * profile.h_rms
    assert_allclose(persson.mean_gap_spectrum(q, spectrum, p0, 5, area=2.5), gap, rtol=1e-11)
    function = persson.mean_gap_spectrum(
        q[[0, -1]], lambda q: 0.7 * q ** (-2 - 2 * hurst), p0, 5, area=2.5
    )
    assert_allclose(function, gap, rtol=1e-10)


def test_spectrum_rms_values_and_rolloff():
    """h_rms and g_rms of a rolled-off spectrum by quadrature; a sampled spectrum and a function
    agree."""

    def spectrum(q):
        return (1 + (q / 4) ** 2) ** -1.8

    profile = SlopeProfile.from_spectrum([1, 400], spectrum)
    h2 = quad(lambda q: q * spectrum(q) / (2 * np.pi), 1, 400, limit=200)[0]
    g2 = quad(lambda q: q**3 * spectrum(q) / (2 * np.pi), 1, 400, limit=200)[0]
    assert (profile.h_rms, profile.g_rms) == pytest.approx((np.sqrt(h2), np.sqrt(g2)), rel=1e-10)
    q = np.geomspace(1, 400, 8000)
    p0 = np.geomspace(0.01, 1, 4) * profile.g_rms
    assert_allclose(
        persson.mean_gap_spectrum(q, spectrum(q), p0),
        persson.mean_gap_spectrum([1, 400], spectrum, p0),
        rtol=1e-7,
    )


OUT_OF_RANGE = [
    (np.nan, 0.5, 0.1),
    (-1, 0.5, 0.1),
    (0.1, 1.01, 0.1),
    (0.1, -0.1, 0.1),
    (0.1, 0.5, 0),
    (0.1, 0.5, 2),
    (0.1, 0.5, 0.1, 3),
    (0.1, "x", 0.1),
    (0.1, 0.5, 0.1, 0.42, False, "m"),
    ([1], [1], 1.0),
    ([2, 1], [1, 1], 1.0),
    ([1, 2], [1, 0], 1.0),
    ([1, 2], [1], 1.0),
    ([0, 1], [1, 1], 1.0),
]


def test_arguments_out_of_range_are_refused():
    for arguments in OUT_OF_RANGE:
        with refused("allowed"):
            curves = persson.mean_gap, persson.mean_gap_spectrum
            curves[isinstance(arguments[0], list)](*arguments)
