"""Clusters of masks on slabs, against a walk from point to point over the unfolded plane."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from masks import found, masks, walk
from scipy import ndimage

from hpc_gfmd.parallel import clusters

pytestmark = pytest.mark.mpi


@pytest.mark.parametrize("points", [1, 30, 2**20])
def test_any_mask(comm, monkeypatch, points):
    """Strips of one row, of a few rows, of all, which are joined as the rows of several ranks
    are."""
    monkeypatch.setattr(clusters, "STRIP_POINTS", points)

    @settings(max_examples=60, derandomize=True, deadline=None, database=None)
    @given(mask=masks, periodic=st.tuples(st.booleans(), st.booleans()), corners=st.booleans())
    def check(mask, periodic, corners):
        assert found(comm, mask, periodic, corners) == walk(mask, periodic, corners)

    check()


@settings(max_examples=60, derandomize=True, deadline=None, database=None)
@given(mask=masks)
def test_contact_or_gap(comm, mask):
    """Where no points that share a side go around the cell, those of the other kind that share a
    corner do, and the other way round."""
    assert any(found(comm, mask)[1]) or any(found(comm, ~mask, corners=True)[1])
    assert any(found(comm, ~mask)[1]) or any(found(comm, mask, corners=True)[1])


@pytest.mark.parametrize("corners", [False, True])
def test_free_clusters_are_those_of_scipy(comm, corners):
    mask = ndimage.gaussian_filter(np.random.default_rng(1).standard_normal((61, 47)), 1.0) > 0.1
    labels, _ = ndimage.label(mask, np.ones((3, 3)) if corners else None)
    assert found(comm, mask, (False, False), corners)[0] == sorted(
        np.bincount(labels.ravel())[1:].tolist()
    )


def steps(n, along):
    """Points of a closed way on n x n points that goes around the cell along[0] and along[1]
    times."""
    mask = np.zeros((n, n), bool)
    for t in np.linspace(0, 1, 40 * n, endpoint=False):
        mask[tuple(int(n * t * k) % n for k in along)] = True
    return mask


@pytest.mark.parametrize("along", [(1, 0), (0, 1), (1, 1), (1, 2), (3, 1)])
def test_ways_around_the_cell(comm, along):
    """Also ways that go around twice: whoever only looks whether a cluster meets its own image
    modulo 2 misses those."""
    mask = steps(24, along)
    assert found(comm, mask, corners=True) == ([int(mask.sum())], (along[0] > 0, along[1] > 0))


def test_reaching_both_edges_is_not_going_around(comm):
    """A stair from the first row to the last, whose ends do not meet across the border."""
    mask = np.zeros((9, 9), bool)
    for i, j in product(range(9), range(9)):
        mask[i, j] = j == i // 3 or (i % 3 == 0 and j == i // 3 - 1)
    assert found(comm, mask, (True, True))[1] == (False, False)
    assert found(comm, mask, (False, False))[1] == (True, False)
