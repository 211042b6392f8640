"""What contacts on coarser grids tell, along the curve between them and that of the finer grid."""

from math import inf

import pytest

from hpc_gfmd.driver.grid_errors import _change


@pytest.mark.parametrize("holds_gap", [False, True])
def test_points_of_one_curve_differ_by_what_may_be_wrong_of_the_way(holds_gap):
    """On the way from 2 to 1.9 h_rms p falls like exp(-2 gap/h_rms)."""
    of_gap = 2 / 1.9
    of_pressure = of_gap ** (-2 * (2 * 1.9) ** 0.5)
    change = _change(of_pressure, of_gap, 1.9, holds_gap)
    assert 0 < change < 0.6 * (1 - of_pressure if holds_gap else of_gap - 1)


def test_changes_at_what_is_prescribed():
    assert _change(1.0, 1.2, 0.3, holds_gap=False) == pytest.approx(0.2)
    assert _change(0.9, 1.0, 0.3, holds_gap=True) == pytest.approx(0.1)
    assert _change(1.3, 0.0, 0.3, holds_gap=True) == pytest.approx(0.3)


def test_points_that_are_far_away_tell_nothing():
    assert _change(2.0, 1.0, 1e-12, holds_gap=False) == inf
    assert _change(1.0, 1e3, 1e3, holds_gap=True) == inf
