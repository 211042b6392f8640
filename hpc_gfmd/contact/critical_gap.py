"""The critical constriction of a leak: the narrowest place of the widest channel.

Lower a level t from the largest gap. At some t the points whose gap is at least t first connect one
edge with the opposite one (points connect where they share a side, and across the border of the
other axis if the surface is periodic along it). Most of the fluid's pressure drops there (Persson
and Yang 2008).
"""

from functools import partial

import numpy as np

from .base import Contact, Observable

ON_REQUEST = True
SOURCES = (
    "Persson, Yang, J. Phys.: Condens. Matter 20 (2008) 315011, doi:10.1088/0953-8984/20/31/315011",
)


def critical_gap(axis: int, contact: Contact) -> float | None:
    """Return the largest t for which points with a gap >= t reach from edge to edge. Collective.

    Found by bisection over the bit patterns of the gap: those of positive floating-point numbers,
    read as integers, have the same order as the numbers. So the result is exact.

    Parameters
    ----------
    axis : int
        0: edges at both ends of x, 1: of y.
    contact : Contact

    Returns
    -------
    float or None
        In the unit of heights, the same on all ranks; 0 if no channel is open. None for separated
        bodies, whose distance is unknown.
    """
    if contact.is_separated:
        return None
    rows, points = contact.grid.inside
    g = contact.g[:rows, :points]
    comm = contact.grid.comm
    whole = np.dtype(f"i{g.dtype.itemsize}")

    def bits(value: float) -> int:
        """Return the bit pattern of a gap as an integer."""
        return int(g.dtype.type(value).view(whole))

    def spans(level: float) -> bool:
        """Whether points with a gap of at least `level` reach from edge to edge. Collective."""
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
        absent="the bodies are separated",
    )
    for axis in (0, 1)
}
TOGETHER = {"critical_gap": tuple(OBSERVABLES)}
