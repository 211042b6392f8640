"""Contacts with attraction do not depend on the number of ranks."""

import adhesive
import numpy as np
import pytest

import hpc_gfmd

pytestmark = pytest.mark.mpi


def both(comm, z, load, **how):
    """On all ranks, and on this process."""
    how |= {"physical_sizes": (8.0, 8.0), "accuracy": 1e-4, "precision": "double"}
    return [hpc_gfmd.solve(z, load, comm=world, **how) for world in (comm, None)]


def assert_same(found, wanted):
    for name in ("a_r", "gap_mean", "attraction", "separation_work"):
        own, alone = found.value(name), wanted.value(name)
        assert (own is None) == (alone is None), name
        assert own is None or own == pytest.approx(alone, rel=1e-3), name
    assert found.status == wanted.status
    mine = slice(*found.rows)
    error = np.abs(found.pressure - wanted.pressure[mine]).max(initial=0)
    assert error <= 0.02 * wanted.pressure.max()


@pytest.mark.parametrize("boundary", ["periodic", "free", ["free", "periodic"]])
@pytest.mark.parametrize("kappa", [0.3, 1.0])
def test_approach(comm, boundary, kappa):
    z, adhesion = adhesive.wall(4, 4).heights, adhesive.attraction(kappa, 0.1)
    found, wanted = both(comm, z, 0.1, adhesion=adhesion, boundary=boundary)
    assert found.status == "converged"
    assert_same(found, wanted)
    assert found.value("stability") == pytest.approx(wanted.value("stability"), abs=0.05)


def test_retraction_to_separation(comm):
    z, adhesion = adhesive.wall(4, 4).heights, adhesive.attraction(1.0, 0.1)
    loads = [0.3, 0.05, 0.0, -1.0, -2.0]
    pair = both(comm, z, loads, adhesion=adhesion, branch="retraction")
    for found, wanted in zip(*pair, strict=True):
        assert_same(found, wanted)
    assert pair[0][-1].status == "separated"
    assert pair[0].pull_off == pair[1].pull_off
