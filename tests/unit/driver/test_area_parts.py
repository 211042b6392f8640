"""Parts of the search for an area: brackets, the order in which points change sides, the load of a
single contact point."""

from math import copysign, inf

import numpy as np
import pytest
from contacts import random_heights, sweep_over

from hpc_gfmd.bodies.halfspace import HALF_SPACE
from hpc_gfmd.bodies.layer import Layer
from hpc_gfmd.driver.bracket import Bound, Bracket, _share
from hpc_gfmd.driver.load import Load
from hpc_gfmd.driver.side_changes import SideChanges
from hpc_gfmd.parallel.grid import Grid

ROOT = 0.3


@pytest.mark.parametrize(
    ("function", "most_steps"),
    [
        (lambda x: x - ROOT, 4),
        (lambda x: (x - ROOT) ** 3, 60),
        # slopes of a gap and of a pressure
        (lambda x: (x - ROOT) * (100 if x < ROOT else 1), 60),
        (lambda x: copysign(inf, x - ROOT), 60),  # only the side is known
    ],
)
def test_bracket_converges_to_the_root(function, most_steps):
    bracket = Bracket()
    for x in (-1.0, 2.0):
        bracket.add(Bound(x, 0.0, function(x)), is_low=function(x) < 0)
    resolution = 1e-12
    steps = 0
    while bracket.high.x - bracket.low.x > 2.5 * resolution:
        x = bracket.between(resolution)
        assert bracket.low.x < x < bracket.high.x
        bracket.add(Bound(x, 0.0, function(x)), is_low=function(x) < 0)
        steps += 1
        assert steps <= most_steps
    assert bracket.low.x - resolution <= ROOT <= bracket.high.x + resolution


def bounds(*distances):
    """Bounds at loads whose inverse is a parabola: x = 1 + y + y^2/5 of a distance y, so 1 is the
    root."""
    return [Bound(1 + y + y**2 / 5, 0.0, y) for y in distances]


@pytest.mark.parametrize(
    ("distances", "share"),
    [
        ((-0.5, 0.8), 0.5 / 1.3),  # a secant
        ((-0.5, 0.8, -0.9), None),  # inverse quadratic interpolation, exact here
        ((0.3, -0.5, 0.7), None),
        ((-0.5, 0.8, -0.5), 0.5),  # no parabola through these
        ((-0.5, 0.8, 0.8), 0.5),
        ((-3.0, 0.8, -4.0), 0.5),  # Chandrupatla's conditions do not hold
        ((-0.5, -0.5), 0.5),
        ((-inf, 0.8), 0.5),
        ((-0.5, 0.8, -inf), 0.5),
    ],
)
def test_share_of_the_way_between_bounds(distances, share):
    newest, opposite, *replaced = bounds(*distances)
    if share is None:
        share = (1 - newest.x) / (opposite.x - newest.x)
    assert _share(newest, opposite, *replaced or [None]) == pytest.approx(share, rel=1e-12)


def test_contradicting_bounds_are_dropped():
    bracket = Bracket()
    bracket.add(Bound(1.0, 0.0, -1.0), is_low=True)
    bracket.add(Bound(0.5, 0.0, 1.0), is_low=False)
    assert bracket.low is None
    assert bracket.excludes(0.6)
    assert not bracket.excludes(0.4)


@pytest.mark.parametrize("free", [(False, False), (True, False)])
def test_order_in_which_points_change_sides(free):
    """Ranks agree with sorting all points."""
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
def test_point_compliance(body, n):
    """The displacement by a pressure on the same point agrees with the sum over all modes."""
    grid = Grid(n, (1.0, n[1] / n[0] if n[0] > 1 else 1.0))
    q_x, q_y = (2 * np.pi * np.fft.fftfreq(k) * grid.a / s for k, s in zip(n, grid.spacings))
    q = np.hypot(q_x[:, None], q_y).ravel()[1:]
    exact = np.sum(1 / body.stiffness(q, grid.a)) / np.prod(n)
    assert body.point_compliance(grid) == pytest.approx(exact, rel=0.02)


@pytest.mark.parametrize("height", [3.0, 50.0])
def test_load_of_a_single_contact_point(height):
    """At this load one point is in contact, at 1.2 times this load more are."""
    z = random_heights((32, 32), seed=2)
    z[3, 5] = z.max() + height
    sweep = sweep_over(z, accuracy=1e-4)
    alone = sweep.working.heights.alone * sweep.working.pressure_unit
    assert sweep.solve(Load("pressure", alone)).contact_points == 1
    assert sweep.solve(Load("pressure", 1.2 * alone)).contact_points > 1
