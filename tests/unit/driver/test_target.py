"""The root-finder for a load, on curves in closed form instead of contacts."""

from math import copysign, exp, inf, log
from types import SimpleNamespace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hpc_gfmd.driver.height_statistics import HeightStatistics
from hpc_gfmd.driver.root import Root
from hpc_gfmd.scene import SolverTable

TOLERANCE = 1e-3
HEIGHTS = HeightStatistics(10_000, 1, 1, top=3.0, lowest=0.0, steepness=1.0, alone=0.0)


class Curve(Root):
    """Finds the mean pressure p0 at which curve(p0) = y."""

    quantity = "y"

    def __init__(self, curve, value, start=1.0, hardness=inf, earlier=()):
        self.curve = curve
        self.start = start
        settings = SolverTable(accuracy=TOLERANCE)
        working = SimpleNamespace(
            heights=HEIGHTS, hardness=hardness, surface=None, settings=settings
        )
        super().__init__(value, working, earlier)

    def guess(self, surface):
        return self.x_of(self.start)

    def straight(self, y):
        return log(y) if y > 0 else -inf

    def certified(self, solver, certificate):
        return self.curve(solver.state.p0), 0.0


class Steps(Curve):
    """A curve in steps: its bracket is never left."""

    in_steps = True

    def distance(self, solver, y):
        return self.curve.distance(solver.state.p0)


class Solver:
    """A solver that records its loads and needs no iterations."""

    def __init__(self, p0):
        self.loads = [p0]

    @property
    def state(self):
        return SimpleNamespace(p0=self.loads[-1])

    def continue_at(self, p0):
        self.loads.append(p0)


def loads_tried(target):
    """All loads until the target is met."""
    solver = Solver(target.p0)
    while target.judge(solver, None) >= 1:
        assert target.correct(solver, None, True), solver.loads
    assert target.miss(target.curve(solver.state.p0)) <= TOLERANCE
    return solver.loads


@settings(max_examples=60)
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

    loads = loads_tried(Curve(curve, curve(p0), p0 * exp(off)))
    assert loads[-1] == pytest.approx(p0, rel=2 * TOLERANCE / exponent)
    assert len(loads) < 3 + abs(off) / log(2) + 8


def test_nearly_flat_curve_is_crossed():
    def curve(p):
        return 0.2 + 1e-4 * log(p) if p < 0.5 else p

    loads = loads_tried(Curve(curve, 0.8, 0.01))
    assert loads[-1] == pytest.approx(0.8, rel=2 * TOLERANCE)


@settings(max_examples=60)
@given(root=st.floats(0.02, 40.0), kind=st.sampled_from(["line", "cubic", "kink", "side"]))
def test_steps_are_enclosed(root, kind):
    """Between bounds the load converges to the root, whatever the distance tells of it."""
    distances = {
        "line": lambda p: p - root,
        "cubic": lambda p: (p - root) ** 3,
        "kink": lambda p: (p - root) * (100 if p < root else 1),
        "side": lambda p: copysign(inf, p - root),
    }

    def curve(p):  # the middle step is as narrow as the tolerance
        return 1.0 if abs(p / root - 1) < TOLERANCE else 0.5 if p < root else 2.0

    curve.distance = distances[kind]
    target = Steps(curve, 1.0)
    loads = loads_tried(target)
    assert loads[-1] == pytest.approx(root, rel=2 * TOLERANCE)
    assert len(loads) < 45


def test_plateaus_are_left_at_their_end():
    """The distance is linear on a plateau, so its end is known after two loads."""

    def curve(p):
        return 0.5 if p < 3.0 else 1.0

    curve.distance = lambda p: p - 3.1
    loads = loads_tried(Steps(curve, 1.0, start=0.1))
    assert len(loads) <= 4


def test_predictions_are_followed_between_the_bounds():
    target = Curve(lambda p: p, 1.0, start=0.8)
    x = target.propose(0.8, 0.0, certified=False)
    assert exp(x) == pytest.approx(1.0)
    assert target.propose(0.8, 1.0, certified=False) is None  # too inaccurate to be followed
    assert target.propose(0.8, 0.0, certified=False, allowed=0.3) is None
    target.bound(0.8, -0.2)
    assert target.propose(1.2, 0.0, certified=False) is None  # beyond the bound
