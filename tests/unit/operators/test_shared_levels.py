"""The levels that ranks share, all of them on one process."""

import pytest
from contacts import rough, solve_scene

from hpc_gfmd.operators.multilevel import Multilevel
from hpc_gfmd.solvers import bpx


def test_a_contact_takes_the_same_pairs_on_shared_levels(monkeypatch):
    """As on levels that one process sweeps alone."""
    surface = rough((2, 32, 4), seed=5)
    alone = solve_scene(surface, 0.01, accuracy=1e-3)
    made = []

    def shared(*arguments):
        made.append(Multilevel(*arguments, coarsest_points=0))
        return made[-1]

    monkeypatch.setattr(bpx, "Multilevel", shared)
    contact = solve_scene(surface, 0.01, accuracy=1e-3)
    assert max(levels.distributed for levels in made) >= 2
    assert contact.status == "converged"
    assert contact.pairs == alone.pairs
    assert contact.contact_points == pytest.approx(alone.contact_points, rel=1e-3)
