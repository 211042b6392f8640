"""Bounds of a load that is looked for."""

import pytest

from hpc_gfmd.driver.bracket import Bracket


def test_bounds_close_in():
    bracket = Bracket()
    assert bracket.width == float("inf")
    assert bracket.within(7.0) == 7.0
    bracket.add((1.0, 0.1, 0.0), large=False, least=1e-9)
    bracket.add((3.0, 0.3, 0.0), large=True, least=1e-9)
    bracket.add((2.0, 0.2, 0.0), large=False, least=1e-9)
    assert bracket.width == 1.0
    assert bracket.within(2.2) == 2.2
    assert [bracket.within(x) for x in (1.5, 2.0, 3.0, float("inf"))] == [2.5] * 4


@pytest.mark.parametrize("large", [True, False])
def test_a_bound_that_another_contradicts_goes(large):
    """Too small at a larger load than one that is too large: the later one is believed."""
    bracket = Bracket()
    bracket.add((1.0, 0.1, 0.0), large=large, least=1e-9)
    bracket.add((2.0 if large else 0.5, 0.2, 0.0), large=not large, least=1e-9)
    assert (bracket.high is None) == large
    assert (bracket.low is None) == (not large)


def test_bounds_too_near_to_each_other_go():
    bracket = Bracket()
    bracket.add((1.0, 0.1, 0.0), large=False, least=1e-3)
    bracket.add((1.0001, 0.2, 0.0), large=True, least=1e-3)
    assert bracket == Bracket()


def test_where_nothing_changes():
    bracket = Bracket()
    assert bracket.stands((1.0, 0.1, 0.0), large=False, least=1e-3) == 0
    bracket.add((1.0, 0.1, 0.0), large=False, least=1e-9)
    assert bracket.stands((1.25, 0.1, 0.0), large=False, least=1e-3) == 0.25
    assert bracket.stands((1.25, 0.102, 0.0), large=False, least=1e-3) == 0
    assert bracket.stands((0.75, 0.1, 0.0), large=True, least=1e-3) == 0
