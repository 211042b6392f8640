"""Closed forms of adhesive contacts against limits, printed values and each other."""

import numpy as np
import pytest
from adhesive_forms import AdhesiveWave, JohnsonKendallRoberts, dmt_pull_off, maugis_pull_off

from hpc_gfmd.theory import adhesion, elastic
from hpc_gfmd.util.errors import SceneError

R = 2.0
W = 0.3
E_STAR = 5.0


def test_jkr_ball():
    """The radius at zero force is (9 pi w R^2/(2 E*))^(1/3); weak attraction gives Hertz."""
    ball = JohnsonKendallRoberts(R, W, E_STAR)
    assert ball.radius(0.0) == pytest.approx(np.cbrt(9 * np.pi * W * R**2 / (2 * E_STAR)))
    assert ball.pull_off == pytest.approx(-1.5 * np.pi * W * R)
    assert ball.radius(ball.pull_off * (1 - 1e-9)) == pytest.approx(
        ball.radius(0.0) / np.cbrt(4), rel=1e-3
    )
    assert np.isnan(ball.radius(1.01 * ball.pull_off))
    weak = JohnsonKendallRoberts(R, 1e-9, E_STAR)
    assert weak.radius(1.0) == pytest.approx(elastic.Hertz(R, 1.0, E_STAR).a, rel=1e-4)


@pytest.mark.parametrize(
    ("lam", "force"), [(1e-3, 2.0), (0.3, 1.816), (1.0, 1.601), (5.0, 1.506), (1e2, 1.5)]
)
def test_maugis_is_between_dmt_and_jkr(lam, force):
    assert -maugis_pull_off(lam) == pytest.approx(force, rel=1e-3)
    assert dmt_pull_off(R, W) == pytest.approx(-2 * np.pi * W * R)


def test_tabor():
    assert adhesion.tabor(8.0, 1.0, 2.0) == pytest.approx(1.0)
    assert adhesion.tabor(8.0, 1.0, 2.0, 8.0) == pytest.approx(0.25)


def test_adhesive_wave():
    wave = AdhesiveWave((0.3 * np.pi) ** 2 / 2)
    assert wave.alpha == pytest.approx(0.3)
    assert wave.pull_off / wave.p_full == pytest.approx(-0.09594, rel=1e-3)
    assert wave.a_r(0.2 * wave.p_full) == pytest.approx(0.5, rel=1e-6)
    assert np.isnan(wave.a_r(1.1 * wave.pull_off))
    weak = AdhesiveWave(1e-12)
    assert weak.a_r(0.3 * weak.p_full) == pytest.approx(
        elastic.Westergaard(0.3, L=np.pi).a_r, rel=1e-4
    )


def test_stickiness():
    """The criterion as printed compares (g Delta/(kappa l)) (g d/(4 Delta))^(2/3) with
    pi (3/16)^(2/3)."""
    a_r = 0.02
    p = 0.01
    slope = 0.1
    d = 3.0
    w = 0.002
    reach = 0.05
    kappa = a_r * slope / p
    printed = slope * reach / (kappa * w) * (slope * d / (4 * reach)) ** (2 / 3)
    parameter = adhesion.stickiness(a_r, p, slope, d, w, reach)
    assert parameter == pytest.approx(np.pi * (3 / 16) ** (2 / 3) / printed)


@pytest.mark.parametrize(
    ("call", "name"),
    [
        (lambda: adhesion.tabor(-1.0, 1.0, 1.0), "R"),
        (lambda: adhesion.stickiness(2.0, 1.0, 1.0, 1.0, 1.0, 1.0), "a_r"),
    ],
)
def test_numbers_out_of_range_are_refused(call, name):
    with pytest.raises(SceneError, match=f"{name}: found .*allowed"):
        call()
