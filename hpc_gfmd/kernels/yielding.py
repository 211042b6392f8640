"""Points at which the pressure is the hardness: functions of a point for kernels.

Letters: g gap, p pressure, H hardness. H is None where there is none: numba then compiles a variant
in which `limit` and `yields` are constants. Zero and one come in the precision of the fields.
"""

from .jit import inline


@inline
def limit(H, zero):
    """Return the pressure of a point that yields: H, or `zero` without a hardness."""
    if H is None:
        return zero
    return H


@inline
def yields(g, p, H, zero, one):
    """Return `one` if a point yields, else `zero`: it has a dent, or touches with p >= H."""
    if H is None:
        return zero
    return one if g < zero or (g <= zero and p >= H) else zero


@inline
def landing(v, plastic, length, H, zero):
    """Return the gap after a step to v, the proximal map (< 0: a dent); plastic: before it."""
    if H is None:
        return max(v, zero)
    if plastic > zero:
        return min(v, zero) + max(v - length * H, zero)
    return max(v, zero) + min(v + length * H, zero)


@inline
def at_contact(w, g, e, H, zero):
    """Return whether a step, or its stored e, takes a point to g = 0; w: as of `landing`."""
    if H is None:
        return w <= zero or e <= -g
    return w == zero or (w > zero and e <= -g) or (w < zero and e >= -g)
