"""The pressure with which the duality gap is computed is admissible."""

from types import SimpleNamespace

import numpy as np
import pytest

from hpc_gfmd.operators.wall import HardWall, Wall

p = np.random.default_rng(5).uniform(0, 3, 200)


def wall_with(hardness):
    """A wall, and (sum of the pressure in contact with it, points in contact, yielded)."""
    problem = SimpleNamespace(grid=None, limit=hardness, hardness=hardness, law=lambda: None)
    limit = hardness or np.inf
    sums = np.minimum(p, limit).sum(), p.size, int(np.sum(p >= limit))
    return (Wall if hardness is None else HardWall)(problem), sums


@pytest.mark.parametrize("over", [0.6, 0.95, 1.0, 1.05, 1.2])
@pytest.mark.parametrize("hardness", [None, 2.0, 5.0])
def test_it_bears_the_load_within_its_limits(hardness, over):
    wall, sums = wall_with(hardness)
    load = over * sums[0]
    scale, shift = wall.admissible(load, *sums)
    limit = hardness or np.inf
    p_hat = np.where(p < limit, scale * p + shift, limit)
    assert p_hat.sum() == pytest.approx(load, rel=1e-12)
    assert 0 <= p_hat.min()
    assert p_hat.max() <= limit
    if over == 1:
        assert (scale, shift) == pytest.approx((1, 0), abs=1e-12)


def test_more_than_the_contact_can_bear():
    wall, sums = wall_with(2.0)
    assert wall.admissible(2.0 * p.size + 1, *sums)[0] < 0
    assert wall.admissible(2.0 * sums[2] - 1, *sums)[0] < 0
    assert wall_with(None)[0].admissible(1.0, 0.0, p.size, 0)[0] < 0
