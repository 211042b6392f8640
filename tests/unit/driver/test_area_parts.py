"""Parts of the search for an area: the order in which points change sides, the load of a single
contact point."""

import numpy as np
import pytest
from contacts import random_heights, sweep_over

from hpc_gfmd.bodies.halfspace import HALF_SPACE
from hpc_gfmd.bodies.layer import Layer
from hpc_gfmd.driver.load import Load
from hpc_gfmd.driver.quantities import Area
from hpc_gfmd.parallel.grid import Grid


@pytest.mark.parametrize("free", [(False, False), (True, False)])
def test_order_in_which_points_change_sides(free):
    """Ranks agree with sorting all points."""
    sweep = sweep_over(random_heights((24, 20), seed=1), free=free, accuracy=1e-3)
    contact = sweep.solve(Load("a_r", 0.2))
    solver = sweep.starter.solver
    stiffness = solver.problem.body.scale(solver.grid)
    g, p = (np.asarray(field[:24, :20], float) for field in (solver.g, solver.p))
    values = np.sort(np.where(g > 0, g * stiffness, -p), axis=None)
    ranks = (1, 7, contact.contact_points, contact.contact_points + 1, contact.N)
    target = Area(0.2, 1e-3, True, sweep.working)
    changes = target.changes(solver, *ranks)
    assert changes == pytest.approx([values[rank - 1] for rank in ranks], rel=1e-6)
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
