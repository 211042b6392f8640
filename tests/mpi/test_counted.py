"""Patches, perimeters and distributions on slabs equal those of one process exactly."""

from functools import partial

import numpy as np
import pytest
from counted import contact_of, random_fields, walk
from mpi.same import from_rank_0

from hpc_gfmd.contact import all_distributions, all_observables, observables_named

pytestmark = pytest.mark.mpi
COUNTED = list(
    observables_named(
        ["patches", "patches_8", "perimeter", "percolation", "percolation_8", "spanning"]
        + ["critical_gap"]
    )
)


@pytest.mark.parametrize("share", [0.02, 0.4, 0.6, 0.97])
@pytest.mark.parametrize("n", [(3, 40), (61, 47), (130, 64), (64, 1), (2, 2)])
def test_same_numbers(comm, n, share):
    g, q = random_fields(n, seed=n[0], share=share)
    slab = contact_of(g, q, comm=comm)
    whole = contact_of(g, q)
    for name in COUNTED:
        assert all_observables()[name](slab) == all_observables()[name](whole), name


@pytest.mark.parametrize("n", [(3, 40), (61, 47), (128, 64)])
@pytest.mark.parametrize("name", all_distributions())
def test_same_distributions(comm, n, name):
    g, q = random_fields(n, seed=n[0])
    h = np.random.default_rng(1).random(n)
    on_ranks, alone = (
        all_distributions()[name](contact_of(g, q, (1.0, 1.3), world, h, (3.0, 0.2)))
        for world in (comm, None)
    )
    assert on_ranks.keys() == alone.keys()
    exact = {"edges", "density"}
    for key, array in on_ranks.items():
        tolerances = {"rel": 0, "abs": 0} if key in exact else {"rel": 1e-11, "abs": 1e-14}
        assert array == pytest.approx(alone[key], **tolerances), key
        assert all(np.array_equal(array, of_rank) for of_rank in comm.allgather(array))


def widest(g, periodic, axis):
    """Return the largest level whose points with at least this gap percolate along an axis."""
    levels = np.unique(g)
    return max(level for level in levels if walk(g >= level, periodic, False)[1][axis])


@pytest.mark.parametrize(
    ("n", "nominal"),
    [((40, 30), (20, 15)), ((64, 15), (31, 15)), ((9, 48), (9, 17)), ((4, 8), (2, 4))],
)
def test_free_edges(comm, n, nominal):
    """Points beyond the surface do not count, and points at opposite edges are no neighbours."""
    g, q = random_fields(n, share=0.5)
    part = tuple(slice(0, k) for k in nominal)
    periodic = tuple(a == b for a, b in zip(n, nominal, strict=True))
    contact = contact_of(g, q, sizes=n, comm=comm, nominal=nominal)
    touching = (g <= 0)[part]
    for corners, end in ((False, ""), (True, "_8")):
        sizes, contact_percolates = walk(touching, periodic, corners)
        gap_percolates = walk(~touching, periodic, corners)[1]
        assert all_observables()[f"patches{end}"](contact) == len(sizes)
        assert all_observables()[f"patch_largest{end}"](contact) == max(sizes)
        for kind, expected in (("contact", contact_percolates), ("gap", gap_percolates)):
            names = [f"{kind}_percolates_{axis}{end}" for axis in "xy"]
            assert tuple(all_observables()[name](contact) for name in names) == expected
    for axis in (0, 1):
        around = tuple(periodic[k] and k != axis for k in (0, 1))
        expected = from_rank_0(comm, partial(widest, g[part], around, axis))
        assert all_observables()[f"critical_gap_{'xy'[axis]}"](contact) == expected
    sides = sum(
        np.sum(
            np.diff(
                touching, axis=axis, append=np.take(touching, [0 if periodic[axis] else -1], axis)
            )
        )
        for axis in (0, 1)
    )
    assert all_observables()["perimeter"](contact) == pytest.approx(np.pi / 4 * sides)
    for name, field in (("pressure", q), ("gap", g)):
        edges, density = all_distributions()[name](contact).values()
        values = field[part][field[part] > 0]
        assert density == pytest.approx(
            np.histogram(values, edges)[0] / len(values) / np.diff(edges)
        )
