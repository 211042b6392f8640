"""How far a body may move next to a plastic limit, against the formula at the head of the file."""

from types import SimpleNamespace

import numpy as np
import pytest

from hpc_gfmd.certificate.plastic_limits import further_movement
from hpc_gfmd.kernels.certify import PER_OCTAVE
from hpc_gfmd.operators.problem import Problem
from hpc_gfmd.parallel.grid import Grid

N = 16
HARDNESS = 2.0
WIDTH = 2 ** (1 / PER_OCTAVE)  # of a bin of heights: the bound may be so many times too large


def smallest(sizes, movable, n_open, e, response):
    """The smallest bound over all movements up to the mean gap; sizes: of gaps, or of dents."""
    bounds = []
    for x in [0.0, *sizes[sizes <= LARGEST]]:
        met = HARDNESS * np.sum(sizes <= x)
        t = (movable + met) / n_open
        if t > 0:
            bounds.append(x * met / t + max(e - t * response, 0) ** 2 / (2 * t))
    return min(bounds)


g = np.random.default_rng(3).exponential(size=(N, N))
g[:6] = 0
g[:2, :8] *= -1
g[2, :] = -np.linspace(0.01, 2, N)
g[6, :] = np.geomspace(1e-3, 0.1, N)
CONTACT = float(np.sum(g <= 0))
GAP = float(g[g > 0].sum())
LARGEST = GAP / (N * N - CONTACT)


@pytest.mark.parametrize("e", [0.1, 2.0])
@pytest.mark.parametrize("room", [0.0, 1.0, 30.0])
@pytest.mark.parametrize("side", ["open", "dented"])
def test_the_smallest_bound(side, room, e):
    """Little room on one side of the load, enough on the other."""
    problem = Problem(Grid((N, N), (1.0, 1.0)), np.zeros((N, N)), 1.0, hardness=HARDNESS)
    n_open = N * N - CONTACT
    if side == "open":
        load = HARDNESS * CONTACT - room
        sizes = g[g > 0]
    else:
        load = HARDNESS * np.sum(g < 0) + room
        sizes = -g[g < 0]
    response = 3.0
    bound = further_movement(problem, load, g, GAP, CONTACT, e, response)
    other_room = HARDNESS * np.sum(g == 0) - room
    assert other_room * response > e * n_open  # no bound from the other side
    if room * response >= e * n_open:
        assert bound == 0
    else:
        wanted = smallest(np.sort(sizes), room, n_open, e, response)
        assert wanted * (1 - 1e-12) <= bound <= wanted * WIDTH


def test_nothing_yields_without_a_hardness():
    problem = SimpleNamespace(yields=False)
    assert further_movement(problem, 1.0, g, GAP, CONTACT, 1.0, 1.0) == 0
