"""The critical constriction of a leak: the narrowest place of the widest channel.

Lower the level t from the largest gap: at some t the points whose gap is more than t first reach
from edge to edge (points connected where they share a side; periodic along the other axis, if the
surface is). Most of what leaks passes there (Persson and Yang 2008).
"""

from functools import partial

import numpy as np

from .base import Contact, Observable

ON_REQUEST = True
SOURCES = (
    "Persson, Yang, J. Phys.: Condens. Matter 20 (2008) 315011, doi:10.1088/0953-8984/20/31/315011",
)


def critical_gap(axis: int, contact: Contact) -> float:
    """Return the critical gap along an axis, in the unit of heights. Collective.

    Found by bisection over the bits of the gap: those of positive numbers, read as a whole number,
    are in the order of the numbers.

    Parameters
    ----------
    axis : int
        0: along x, 1: along y.
    contact : Contact

    Returns
    -------
    float
        0 where the widest channel is closed.
    """
    rows, points = contact.grid.inside
    g = contact.g[:rows, :points]
    comm = contact.grid.comm
    whole = np.dtype(f"i{g.dtype.itemsize}")

    def bits(value: float) -> int:
        return int(g.dtype.type(value).view(whole))

    def spans(level: float) -> bool:
        wide = contact.clusters_of(lambda i0, i1: g[i0:i1] >= level, open_axis=axis)
        return wide.percolates[axis]

    low = 0
    high = bits(comm.max([g.max(initial=0)])[0])
    while low < high:
        level = whole.type((low + high + 1) // 2).view(g.dtype)
        if spans(level):
            low = bits(comm.min([g.min(where=g >= level, initial=np.inf)])[0])
        else:
            high = bits(comm.max([g.max(where=g < level, initial=0)])[0])
    return float(whole.type(low).view(g.dtype)) * contact.surface.height_unit


OBSERVABLES = {
    f"critical_gap_{'xy'[axis]}": Observable(
        partial(critical_gap, axis),
        f"largest t for which points with a larger gap reach along {'xy'[axis]} from edge to edge",
        "length",
        SOURCES,
    )
    for axis in (0, 1)
}
TOGETHER = {"critical_gap": tuple(OBSERVABLES)}
