"""Clusters of masks on slabs against a walk from point to point over the unfolded plane."""

import numpy as np
import pytest
from counted import clusters_of, masks, walk
from hypothesis import given, settings
from hypothesis import strategies as st

from hpc_gfmd.parallel import clusters

pytestmark = pytest.mark.mpi


@pytest.mark.parametrize("points", [1, 30, 2**20])
def test_any_mask(comm, monkeypatch, points):
    """With strips of one row, of a few rows and of all rows, which are joined like those of
    ranks."""
    monkeypatch.setattr(clusters, "STRIP_POINTS", points)

    @settings(max_examples=60, derandomize=True, database=None)
    @given(mask=masks, periodic=st.tuples(st.booleans(), st.booleans()), corners=st.booleans())
    def check(mask, periodic, corners):
        assert clusters_of(comm, mask, periodic, corners) == walk(mask, periodic, corners)

    check()


def path_around(n, along):
    """Return the mask of a closed path that winds along[0] and along[1] times around a cell of
    n x n points."""
    mask = np.zeros((n, n), bool)
    for t in np.linspace(0, 1, 40 * n, endpoint=False):
        mask[tuple(int(n * t * k) % n for k in along)] = True
    return mask


@pytest.mark.parametrize("along", [(1, 0), (0, 1), (1, 1), (1, 2), (3, 1)])
def test_paths_around_the_cell(comm, along):
    """Including paths that wind twice, which a test of the winding number modulo 2 would miss."""
    mask = path_around(24, along)
    assert clusters_of(comm, mask, corners=True) == (
        [int(mask.sum())],
        (along[0] > 0, along[1] > 0),
    )
