"""Numbers that classify adhesive contacts."""

import numpy as np
import pytest

from hpc_gfmd.theory import adhesion
from hpc_gfmd.util.errors import SceneError


def test_tabor():
    assert adhesion.tabor(8.0, 1.0, 2.0) == pytest.approx(1.0)
    assert adhesion.tabor(8.0, 1.0, 2.0, 8.0) == pytest.approx(0.25)


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
