"""The parts of the search for an area: bounds, points in the order of their change of sides, the
load that one point carries."""

from math import copysign, inf

import numpy as np
import pytest
from contacts import random_heights, sweep_over

from hpc_gfmd.bodies.halfspace import HALF_SPACE
from hpc_gfmd.bodies.layer import Layer
from hpc_gfmd.driver.bracket import Bound, Bracket
from hpc_gfmd.driver.load import Load
from hpc_gfmd.driver.side_changes import SideChanges
from hpc_gfmd.parallel.grid import Grid

ROOT = 0.3


@pytest.mark.parametrize(
    ("function", "most"),
    [
        (lambda x: x - ROOT, 4),
        (lambda x: (x - ROOT) ** 3, 60),
        (lambda x: (x - ROOT) * (100 if x < ROOT else 1), 60),  # a gap, and a pressure
        (lambda x: copysign(inf, x - ROOT), 60),  # the side alone is known
    ],
)
def test_bounds_meet_at_the_zero(function, most):
    bracket = Bracket()
    for x in (-1.0, 2.0):
        bracket.add(Bound(x, 0.0, function(x)), is_low=function(x) < 0)
    meet, steps = 1e-12, 0
    while bracket.high.x - bracket.low.x > 2.5 * meet:
        x = bracket.between(meet)
        assert bracket.low.x < x < bracket.high.x
        bracket.add(Bound(x, 0.0, function(x)), is_low=function(x) < 0)
        steps += 1
        assert steps <= most
    assert bracket.low.x - meet <= ROOT <= bracket.high.x + meet


def test_a_bound_that_contradicts_is_dropped():
    bracket = Bracket()
    bracket.add(Bound(1.0, 0.0, -1.0), is_low=True)
    bracket.add(Bound(0.5, 0.0, 1.0), is_low=False)
    assert bracket.low is None
    assert bracket.excludes(0.6)
    assert not bracket.excludes(0.4)


@pytest.mark.parametrize("free", [(False, False), (True, False)])
def test_points_in_the_order_of_their_change_of_sides(free):
    """Against all values, sorted."""
    sweep = sweep_over(random_heights((24, 20), seed=1), free=free, accuracy=1e-3)
    contact = sweep.solve(Load("a_r", 0.2))
    solver = sweep.starter.solver
    changes = SideChanges(solver, 1e-12)
    g, p = (np.asarray(field[:24, :20], float) for field in (solver.g, solver.p))
    values = np.sort(np.where(g > 0, g / changes.compliance, -p), axis=None)
    for rank in (1, 7, contact.contact_points, contact.contact_points + 1, contact.N):
        assert changes.of_rank(rank) == pytest.approx(values[rank - 1], abs=1e-11)
    assert values[contact.contact_points - 1] < 0 <= values[contact.contact_points]


@pytest.mark.parametrize("body", [HALF_SPACE, Layer(thickness=0.1, nu=0.3, base="bonded")])
@pytest.mark.parametrize("n", [(16, 16), (200, 100), (1, 300)])
def test_how_far_a_point_is_pressed_down_by_a_pressure_on_it(body, n):
    """Against the sum over all waves."""
    grid = Grid(n, (1.0, n[1] / n[0] if n[0] > 1 else 1.0))
    q_x, q_y = (2 * np.pi * np.fft.fftfreq(k) * grid.a / s for k, s in zip(n, grid.spacings))
    q = np.hypot(q_x[:, None], q_y).ravel()[1:]
    exact = np.sum(1 / body.stiffness(q, grid.a)) / np.prod(n)
    assert body.point_compliance(grid) == pytest.approx(exact, rel=0.02)


@pytest.mark.parametrize("height", [3.0, 50.0])
def test_the_load_that_one_point_carries(height):
    """Below it one point touches, a little above more do."""
    z = random_heights((32, 32), seed=2)
    z[3, 5] = z.max() + height
    sweep = sweep_over(z, accuracy=1e-4)
    alone = sweep.working.heights.alone * sweep.working.pressure_unit
    assert sweep.solve(Load("pressure", alone)).contact_points == 1
    assert sweep.solve(Load("pressure", 1.2 * alone)).contact_points > 1
