"""Adhesive contacts do not depend on the number of ranks."""

import adhesive
import numpy as np
import pytest
from mpi.same import assert_same_fields, solve_twice

pytestmark = pytest.mark.mpi


def solved(comm, z, *load, **arguments):
    """Solutions on all ranks and in one process."""
    how = {"physical_sizes": (8.0, 8.0), "precision": "double"}
    return solve_twice(comm, z, *load, **how, **arguments)


def assert_same(on_ranks, alone):
    for name in ("a_r", "gap_mean", "attraction", "separation_work"):
        number = on_ranks.value(name)
        expected = alone.value(name)
        assert (number is None) == (expected is None), name
        assert number is None or number == pytest.approx(expected, rel=1e-3), name
    assert on_ranks.status == alone.status
    assert_same_fields(on_ranks, alone, ["pressure"], 0.02)


@pytest.mark.parametrize(
    ("boundary", "kappa"), [("periodic", 1.0), (["free", "periodic"], 1.0), ("free", 0.3)]
)
def test_approach(comm, boundary, kappa):
    z = adhesive.wall(4, 4).heights
    adhesion = adhesive.attraction(kappa, 0.1)
    settings = {"accuracy": 1e-4, "boundary": boundary, "unique": True}
    on_ranks, alone = solved(comm, z, 0.1, adhesion=adhesion, **settings)
    assert on_ranks.status == "converged"
    assert_same(on_ranks, alone)
    assert on_ranks.value("unique") == alone.value("unique")
    assert on_ranks.value("stability") == pytest.approx(alone.value("stability"), abs=0.05)


def test_retraction_to_separation(comm):
    z = adhesive.wall(4, 4).heights
    adhesion = adhesive.attraction(1.0, 0.1)
    loads = [0.3, 0.05, 0.0, -1.0, -2.0]
    settings = {"accuracy": 1e-4, "branch": "retraction"}
    pair = solved(comm, z, loads, adhesion=adhesion, **settings)
    for on_ranks, alone in zip(*pair, strict=True):
        assert_same(on_ranks, alone)
    assert pair[0][-1].status == "separated"
    assert pair[0].pull_off == pair[1].pull_off


@pytest.mark.parametrize("boundary", ["periodic", "free"])
def test_prescribed_lengths(comm, boundary):
    """A mean gap and an approach are the same on all ranks, and so is the pressure."""
    adhesion = adhesive.attraction(1.0, 0.1)
    how = {"boundary": boundary, "branch": "retraction"}
    if boundary == "periodic":
        z, lengths = adhesive.wall(4, 4).heights, {"gap_mean": [0.3, 0.5]}
    else:
        x = np.arange(32) / 4 - 4
        z, lengths = -(x[:, None] ** 2 + x**2) / 20, {"approach": [0.05, 0, -0.01]}
    pair = solved(comm, z, adhesion=adhesion, **lengths, **how)
    for on_ranks, wanted in zip(*pair, strict=True):
        assert_same(on_ranks, wanted)
        assert on_ranks.status == "converged"
        assert on_ranks.p == pytest.approx(wanted.p, rel=1e-3, abs=1e-6)
