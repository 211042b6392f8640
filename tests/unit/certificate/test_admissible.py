"""The pressure with which the duality gap is computed is admissible."""

from types import SimpleNamespace

import numpy as np
import pytest

from hpc_gfmd.certificate.certificate import _admissible

p = np.random.default_rng(5).uniform(0, 3, 200)


def sums_of(hardness):
    """(sum of the pressure in contact, sums)"""
    limit = hardness or np.inf
    sums = SimpleNamespace(contact=p.size, yielded=int(np.sum(p >= limit)))
    return np.minimum(p, limit).sum(), sums


@pytest.mark.parametrize("over", [0.6, 0.95, 1.0, 1.05, 1.2])
@pytest.mark.parametrize("hardness", [None, 2.0, 5.0])
def test_it_bears_the_load_within_its_limits(hardness, over):
    closed_p, sums = sums_of(hardness)
    load = over * closed_p
    scale, shift = _admissible(SimpleNamespace(hardness=hardness), load, closed_p, sums)
    limit = hardness or np.inf
    p_hat = np.where(p < limit, scale * p + shift, limit)
    assert p_hat.sum() == pytest.approx(load, rel=1e-12)
    assert 0 <= p_hat.min()
    assert p_hat.max() <= limit
    if over == 1:
        assert (scale, shift) == pytest.approx((1, 0), abs=1e-12)


def test_more_than_the_contact_can_bear():
    closed_p, sums = sums_of(2.0)
    problem = SimpleNamespace(hardness=2.0)
    assert _admissible(problem, 2.0 * p.size + 1, closed_p, sums)[0] < 0
    assert _admissible(problem, 2.0 * sums.yielded - 1, closed_p, sums)[0] < 0
    assert _admissible(SimpleNamespace(hardness=None), 1.0, 0.0, sums)[0] < 0
