"""The pressure in contact, as results have it."""

from .jit import kernel
from .yielding import limit, yields


@kernel
def contact_pressure(g, p, H, out):
    """Write the pressure on some rows: 0 out of contact, the hardness where a point yields.

    Parameters
    ----------
    g, p : array, rows of a local slab
        Gap and pressure of a state.
    H : float or None
        Hardness, in the precision of p.
    out : array (rows, points)
        Gets the pressure of these first points of each row.
    """
    zero = p.dtype.type(0)
    one = p.dtype.type(1)
    at_limit = limit(H, zero)
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            touches = (g[i, j] <= zero) & (p[i, j] > zero)
            plastic = yields(g[i, j], p[i, j], H, zero, one)
            out[i, j] = at_limit if plastic > zero else (p[i, j] if touches else zero)
