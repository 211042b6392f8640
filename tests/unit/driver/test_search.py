"""The search for a load on curves in closed form instead of contacts."""

from dataclasses import dataclass
from math import exp, inf, log
from types import SimpleNamespace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hpc_gfmd.driver.height_statistics import HeightStatistics
from hpc_gfmd.driver.load_search import SecantSearch

TOLERANCE = 1e-3
HEIGHTS = HeightStatistics(10_000, 1, 1, top=3.0, lowest=0.0, steepness=1.0, alone=0.0)


@dataclass
class CurveSearch(SecantSearch):
    """A search for curve(p0) = y, p0 the mean pressure."""

    usual = 1.0
    curve: object = None

    def straight(self, y):
        return log(y) if y > 0 else -inf

    def predicted(self, solver, progress, errors):
        return None

    def certified(self, solver, certificate):
        return self.curve(solver.p0), 0.0

    def within(self, solver, progress, room):
        return True


class Solver:
    """A solver that records its loads and needs no iterations."""

    iterations = 0

    def __init__(self, p0):
        self.p0 = p0
        self.loads = [p0]

    def continue_at(self, p0):
        self.p0 = p0
        self.loads.append(p0)


def loads_of_search(curve, target, start):
    """All loads of a search, of which the last has to meet the target."""
    search = CurveSearch(target, TOLERANCE, True, HEIGHTS, HEIGHTS, x=log(start), curve=curve)
    solver = Solver(search.p0)
    certificate = SimpleNamespace()
    while search.learn(solver, certificate) >= 1:
        assert search.correct(solver, certificate, True), solver.loads
    assert search.miss(curve(solver.p0)) <= TOLERANCE
    return solver.loads


@settings(max_examples=60, deadline=None)
@given(
    exponent=st.floats(0.2, 3.0),
    scale=st.floats(1e-3, 1e3),
    p0=st.floats(1e-5, 1.0),
    off=st.floats(-4.0, 4.0),
)
def test_powers_of_the_load(exponent, scale, p0, off):
    """A secant in logarithms is exact for powers."""

    def curve(p):
        return scale * p**exponent

    loads = loads_of_search(curve, curve(p0), p0 * exp(off))
    assert loads[-1] == pytest.approx(p0, rel=2 * TOLERANCE / exponent)
    assert len(loads) < 3 + abs(off) / log(2) + 8


@settings(max_examples=60, deadline=None)
@given(p0=st.floats(1e-4, 0.9), off=st.floats(-3.0, 3.0))
def test_saturating_curve(p0, off):
    def curve(p):
        return p / (p + 0.1)

    loads_of_search(curve, curve(p0), p0 * exp(off))


def test_plateaus_are_crossed():
    """Steps are doubled where the value hardly rises."""

    def curve(p):
        return 0.2 + 1e-4 * log(p) if p < 0.5 else p

    loads = loads_of_search(curve, 0.8, 0.01)
    assert loads[-1] == pytest.approx(0.8, rel=2 * TOLERANCE)


def test_search_resumes_at_a_given_load():
    search = CurveSearch(0.3, TOLERANCE, True, HEIGHTS, HEIGHTS, curve=lambda p: p)
    search.begin_at(0.123)
    assert search.p0 == pytest.approx(0.123, rel=1e-12)


@given(p0=st.floats(1e-6, 0.999), closes_at=st.sampled_from([1.0, inf]))
def test_search_variable_maps_to_the_load(p0, closes_at):
    search = CurveSearch(0.3, TOLERANCE, True, HEIGHTS, HEIGHTS, closes_at=closes_at)
    search.x = search.x_of(p0)
    assert search.p0 == pytest.approx(p0, rel=1e-9)


@pytest.mark.parametrize(
    ("step", "factor", "error", "way", "slope"),
    [
        (0.5, exp(1.0), 0.0, 0.0, 2.0),  # the last two values give the slope
        (0.5, 1.0, 0.0, 1.0, 1.0),  # a plateau: twice the last step at least
        (-0.5, 1.0, 0.0, 1.0, 1.0),
        (0.5, exp(0.01), 0.0, 1.0, 1.0),
        (0.5, exp(10.0), 0.0, 0.0, 1.0),  # too steep to be used
        (0.5, exp(1.0), 0.6, 0.0, 1.0),  # within the error
        (0.5, 0.0, 0.0, 0.0, 1.0),  # no contact
    ],
)
def test_secant_of_the_last_two_values(step, factor, error, way, slope):
    search = CurveSearch(1.0, TOLERANCE, True, HEIGHTS, HEIGHTS, slope=1.0)
    search.x = 0.0
    assert search.secant(2.0) == 0.0
    search.x = step
    assert search.secant(2.0 * factor, error) == pytest.approx(way)
    assert search.slope == pytest.approx(slope)
