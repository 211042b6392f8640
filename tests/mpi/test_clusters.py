"""Clusters of masks, against a walk from point to point over the unfolded plane."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from hpc_gfmd.parallel import clusters
from hpc_gfmd.parallel.clusters import find_clusters
from hpc_gfmd.parallel.fft import row_starts

pytestmark = pytest.mark.mpi

SIDES = [(1, 0), (-1, 0), (0, 1), (0, -1)]
CORNERS = [(1, 1), (1, -1), (-1, 1), (-1, -1)]


def walk(mask, periodic, corners):
    """(sorted sizes, percolation along x and y) by visiting one point after another."""
    n, seen, sizes, percolates = mask.shape, {}, [], [False, False]
    for start in zip(*np.nonzero(mask), strict=True):
        if start in seen:
            continue
        sides, size = [set(), set()], 0
        todo, seen[start] = [start], (0, 0)
        while todo:
            here = todo.pop()
            size += 1
            for axis in (0, 1):
                sides[axis].add(here[axis])
            for step in SIDES + CORNERS * corners:
                there = tuple(h + s for h, s in zip(here, step, strict=True))
                if any(not periodic[axis] and not 0 <= there[axis] < n[axis] for axis in (0, 1)):
                    continue
                cell = tuple(seen[here][axis] + there[axis] // n[axis] for axis in (0, 1))
                there = tuple(there[axis] % n[axis] for axis in (0, 1))
                if not mask[there]:
                    continue
                if there not in seen:
                    seen[there] = cell
                    todo.append(there)
                for axis in (0, 1):
                    percolates[axis] |= bool(periodic[axis] and seen[there][axis] != cell[axis])
        sizes.append(size)
        for axis in (0, 1):
            percolates[axis] |= not periodic[axis] and {0, n[axis] - 1} <= sides[axis]
    return sorted(sizes), tuple(percolates)


def found(comm, mask, periodic=(True, True), corners=False):
    """(sorted sizes of all ranks, percolation) of the mask, each rank having its rows."""
    starts = row_starts(len(mask), comm.size)
    rows = int(starts[comm.rank]), int(starts[comm.rank + 1])
    mine = mask[slice(*rows)]
    result = find_clusters(comm, lambda i0, i1: mine[i0:i1], rows, mask.shape, periodic, corners)
    assert all(other == result.percolates for other in comm.allgather(result.percolates))
    return sorted(int(size) for sizes in comm.allgather(result.sizes) for size in sizes), result.percolates


masks = st.builds(lambda n, seed, share: np.random.default_rng(seed).random(n) < share,
                  st.tuples(st.integers(1, 12), st.integers(1, 12)), st.integers(0, 10**6), st.floats(0.1, 0.9))


@settings(max_examples=150, derandomize=True, deadline=None, database=None)
@given(mask=masks, periodic=st.tuples(st.booleans(), st.booleans()), corners=st.booleans(), strip=st.sampled_from([1, 30, 2**20]))
def test_any_mask(comm, mask, periodic, corners, strip):
    usual, clusters.STRIP_POINTS = clusters.STRIP_POINTS, strip  # strips of one row, of a few, of all
    try:
        assert found(comm, mask, periodic, corners) == walk(mask, periodic, corners)
    finally:
        clusters.STRIP_POINTS = usual


@pytest.mark.parametrize("corners", [False, True])
def test_free_clusters_are_those_of_scipy(comm, corners):
    mask = ndimage.gaussian_filter(np.random.default_rng(1).standard_normal((61, 47)), 1.0) > 0.1
    labels, _ = ndimage.label(mask, np.ones((3, 3)) if corners else None)
    assert found(comm, mask, (False, False), corners)[0] == sorted(np.bincount(labels.ravel())[1:].tolist())


def steps(n, along):
    """Points of a closed way on n x n points that goes around the cell along[0] and along[1] times."""
    mask = np.zeros((n, n), bool)
    for t in np.linspace(0, 1, 40 * n, endpoint=False):
        mask[tuple(int(n * t * k) % n for k in along)] = True
    return mask


@pytest.mark.parametrize("along", [(1, 0), (0, 1), (1, 1), (1, 2), (3, 1)])
def test_ways_around_the_cell(comm, along):
    """Also ways that go around twice: whoever only looks whether a cluster meets its own image modulo 2 misses those."""
    mask = steps(24, along)
    assert found(comm, mask, corners=True) == ([int(mask.sum())], (along[0] > 0, along[1] > 0))


def test_reaching_both_edges_is_not_going_around(comm):
    """A stair from the first row to the last, whose ends do not meet across the border."""
    mask = np.zeros((9, 9), bool)
    for i, j in product(range(9), range(9)):
        mask[i, j] = j == i // 3 or (i % 3 == 0 and j == i // 3 - 1)
    assert found(comm, mask, (True, True))[1] == (False, False)
    assert found(comm, mask, (False, False))[1] == (True, False)


@settings(max_examples=60, derandomize=True, deadline=None, database=None)
@given(mask=masks)
def test_contact_or_gap(comm, mask):
    """Where no points that share a side go around the cell, those of the other kind that share a corner do, and the other way round."""
    assert any(found(comm, mask)[1]) or any(found(comm, ~mask, corners=True)[1])
    assert any(found(comm, ~mask)[1]) or any(found(comm, mask, corners=True)[1])
