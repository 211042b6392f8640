"""Contacts with given fields for tests of counted observables, and reference clusters of masks by a
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
    """The Contact of a gap g and a pressure p, of which each rank takes its slab.

    Parameters
    ----------
    g, p : array_like (n_x, n_y)
        In units of height and pressure; p is 1 where g is 0 by default.
    sizes
        Of the cell.
    comm
        Communicator; this process alone by default.
    h : array, optional
        Initial gap in units of height.
    units
        (pressure, height).
    nominal
        Grid points of the surface in the cell; all by default.
    """
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
        ridges=(False, False),
        images=1,
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
    """(g, p) of random patches; share: of points in contact, approximately."""
    from scipy import ndimage

    z = ndimage.gaussian_filter(np.random.default_rng(seed).standard_normal(n), smooth, mode="wrap")
    z -= np.quantile(z, share)
    return np.maximum(z, 0), np.maximum(-z, 0)


SIDES = [(1, 0), (-1, 0), (0, 1), (0, -1)]
CORNERS = [(1, 1), (1, -1), (-1, 1), (-1, -1)]


def walk(mask, periodic, corners):
    """(sorted sizes of clusters, percolation along x and y) by visiting points one by one."""
    n = mask.shape
    cells = {}
    sizes = []
    percolates = [False, False]
    for start in zip(*np.nonzero(mask), strict=True):
        if start in cells:
            continue
        sides = [set(), set()]
        size = 0
        todo = [start]
        cells[start] = (0, 0)
        while todo:
            point = todo.pop()
            size += 1
            for axis in (0, 1):
                sides[axis].add(point[axis])
            for step in SIDES + CORNERS * corners:
                unfolded = tuple(h + s for h, s in zip(point, step, strict=True))
                inside = [0 <= unfolded[axis] < n[axis] for axis in (0, 1)]
                if not all(inside[axis] or periodic[axis] for axis in (0, 1)):
                    continue
                cell = tuple(cells[point][axis] + unfolded[axis] // n[axis] for axis in (0, 1))
                neighbour = tuple(unfolded[axis] % n[axis] for axis in (0, 1))
                if not mask[neighbour]:
                    continue
                if neighbour not in cells:
                    cells[neighbour] = cell
                    todo.append(neighbour)
                for axis in (0, 1):
                    wraps = periodic[axis] and cells[neighbour][axis] != cell[axis]
                    percolates[axis] |= bool(wraps)
        sizes.append(size)
        for axis in (0, 1):
            percolates[axis] |= not periodic[axis] and {0, n[axis] - 1} <= sides[axis]
    return sorted(sizes), tuple(percolates)


def clusters_of(comm, mask, periodic=(True, True), corners=False):
    """(sorted sizes of clusters, percolation) by find_clusters, each rank with its rows."""
    starts = row_starts(len(mask), comm.size)
    rows = int(starts[comm.rank]), int(starts[comm.rank + 1])
    mine = mask[slice(*rows)]
    result = find_clusters(comm, lambda i0, i1: mine[i0:i1], rows, mask.shape, periodic, corners)
    assert comm.allgather(result.percolates) == [result.percolates] * comm.size
    sizes = np.concatenate(comm.allgather(result.sizes))
    return sorted(sizes.astype(int).tolist()), result.percolates


masks = st.builds(
    lambda n, seed, share: np.random.default_rng(seed).random(n) < share,
    st.tuples(st.integers(1, 12), st.integers(1, 12)),
    st.integers(0, 10**6),
    st.floats(0.1, 0.9),
)
