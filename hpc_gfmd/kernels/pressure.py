"""The pressure in contact, as results have it."""

from .jit import kernel
from .yielding import limit, yields


@kernel
def contact_pressure(g, p, H, out):
    """Write the pressure on some rows to `out`: 0 out of contact, H where a point yields."""
    zero = p.dtype.type(0)
    one = p.dtype.type(1)
    at_limit = limit(H, zero)
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            touches = (g[i, j] <= zero) & (p[i, j] > zero)
            plastic = yields(g[i, j], p[i, j], H, zero, one)
            out[i, j] = at_limit if plastic > zero else (p[i, j] if touches else zero)
