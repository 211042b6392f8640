"""Contacts of given fields, on slabs, for what is counted on them; masks, and their clusters by a
walk from point to point over the unfolded plane."""

from types import SimpleNamespace

import numpy as np
from hypothesis import strategies as st

from hpc_gfmd.contact.contact import Contact
from hpc_gfmd.parallel.clusters import find_clusters
from hpc_gfmd.parallel.comm import SerialComm
from hpc_gfmd.parallel.grid import Grid
from hpc_gfmd.parallel.layout import row_starts


def contact_of(g, p=None, sizes=(1.0, 1.0), comm=None, h=None, units=(1.0, 1.0), nominal=None):
    """A Contact with gap g and pressure p (default: 1 where g is 0) in units of (pressure,
    height)."""
    grid = Grid(np.shape(g), sizes, comm or SerialComm(), nominal=nominal)
    g = np.asarray(g, dtype=float)
    p = np.where(g > 0, 0.0, 1.0) if p is None else p
    mine = slice(*grid.rows)
    surface = SimpleNamespace(
        grid=grid,
        h=None if h is None else h[mine],
        g_rms=1.0,
        slope=1.0,
        h_rms=0.3 * units[1],
        height_unit=units[1],
        add_spectrum=None,
    )
    certificate = SimpleNamespace(contact=int(np.sum((g <= 0) & (p > 0))))
    return Contact(
        surface,
        units[0],
        1.0,
        np.ascontiguousarray(g[mine]),
        np.ascontiguousarray(p[mine]),
        "converged",
        certificate,
        1e-3,
    )


def random_fields(n, seed=0, share=0.3, smooth=1.5):
    """(g, p) of random patches that touch on about a share of all points."""
    from scipy import ndimage

    z = ndimage.gaussian_filter(np.random.default_rng(seed).standard_normal(n), smooth, mode="wrap")
    z -= np.quantile(z, share)
    return np.maximum(z, 0), np.maximum(-z, 0)


SIDES = [(1, 0), (-1, 0), (0, 1), (0, -1)]
CORNERS = [(1, 1), (1, -1), (-1, 1), (-1, -1)]


def walk(mask, periodic, corners):
    """(sorted sizes, percolation along x and y) by visiting one point after another."""
    n = mask.shape
    seen = {}
    sizes = []
    percolates = [False, False]
    for start in zip(*np.nonzero(mask), strict=True):
        if start in seen:
            continue
        sides = [set(), set()]
        size = 0
        todo = [start]
        seen[start] = (0, 0)
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
    return sorted(
        int(size) for sizes in comm.allgather(result.sizes) for size in sizes
    ), result.percolates


masks = st.builds(
    lambda n, seed, share: np.random.default_rng(seed).random(n) < share,
    st.tuples(st.integers(1, 12), st.integers(1, 12)),
    st.integers(0, 10**6),
    st.floats(0.1, 0.9),
)
