"""Adhesive contacts do not depend on the number of ranks."""

import adhesive
import numpy as np
import pytest
from mpi.same import from_rank_0

import hpc_gfmd

pytestmark = pytest.mark.mpi


def solve_twice(comm, z, *load, **settings):
    """Solve on all ranks and in one process."""
    settings |= {"physical_sizes": (8.0, 8.0), "precision": "double"}
    on_ranks = hpc_gfmd.solve(z, *load, comm=comm, **settings)
    return on_ranks, from_rank_0(comm, lambda: hpc_gfmd.solve(z, *load, **settings))


def assert_same(on_ranks, alone):
    for name in ("a_r", "gap_mean", "attraction", "separation_work"):
        number = on_ranks.value(name)
        expected = alone.value(name)
        assert (number is None) == (expected is None), name
        assert number is None or number == pytest.approx(expected, rel=1e-3), name
    assert on_ranks.status == alone.status
    mine = slice(*on_ranks.rows)
    error = np.abs(on_ranks.pressure - alone.pressure[mine]).max(initial=0)
    assert error <= 0.02 * alone.pressure.max()


@pytest.mark.parametrize(
    ("boundary", "kappa"), [("periodic", 1.0), (["free", "periodic"], 1.0), ("free", 0.3)]
)
def test_approach(comm, boundary, kappa):
    z = adhesive.wall(4, 4).heights
    adhesion = adhesive.attraction(kappa, 0.1)
    settings = {"accuracy": 1e-4, "boundary": boundary, "unique": True}
    on_ranks, alone = solve_twice(comm, z, 0.1, adhesion=adhesion, **settings)
    assert on_ranks.status == "converged"
    assert_same(on_ranks, alone)
    assert on_ranks.value("unique") == alone.value("unique")
    assert on_ranks.value("stability") == pytest.approx(alone.value("stability"), abs=0.05)


def test_retraction_to_separation(comm):
    z = adhesive.wall(4, 4).heights
    adhesion = adhesive.attraction(1.0, 0.1)
    loads = [0.3, 0.05, 0.0, -1.0, -2.0]
    settings = {"accuracy": 1e-4, "branch": "retraction"}
    pair = solve_twice(comm, z, loads, adhesion=adhesion, **settings)
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
    pair = solve_twice(comm, z, adhesion=adhesion, **lengths, **how)
    for on_ranks, wanted in zip(*pair, strict=True):
        assert_same(on_ranks, wanted)
        assert on_ranks.status == "converged"
        assert on_ranks.p == pytest.approx(wanted.p, rel=1e-3, abs=1e-6)
