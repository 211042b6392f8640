"""Clusters of one process, which joins strips of rows as it joins the rows of several ranks."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from masks import found, masks, walk

from hpc_gfmd.parallel import clusters
from hpc_gfmd.parallel.comm import SerialComm


@pytest.mark.parametrize("points", [1, 30, 2**20])
def test_any_mask(monkeypatch, points):
    """Strips of one row, of a few rows, of all."""
    monkeypatch.setattr(clusters, "STRIP_POINTS", points)

    @settings(max_examples=150, derandomize=True, deadline=None, database=None)
    @given(mask=masks, periodic=st.tuples(st.booleans(), st.booleans()), corners=st.booleans())
    def check(mask, periodic, corners):
        assert found(SerialComm(), mask, periodic, corners) == walk(mask, periodic, corners)

    check()


@settings(max_examples=60, derandomize=True, deadline=None, database=None)
@given(mask=masks)
def test_contact_or_gap(mask):
    """Where no points that share a side go around the cell, those of the other kind that share a corner do, and the other way round."""
    assert any(found(SerialComm(), mask)[1]) or any(found(SerialComm(), ~mask, corners=True)[1])
    assert any(found(SerialComm(), ~mask)[1]) or any(found(SerialComm(), mask, corners=True)[1])
