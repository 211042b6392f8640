"""Points at which the pressure is the hardness: functions of a point for kernels.

hardness is None where there is none: numba then compiles a variant in which both are constants, so
that nothing is left of them.
"""

from .jit import inline


@inline
def limit(hardness, zero):
    """Return the pressure of a point that yields: the hardness, 0 without one."""
    if hardness is None:
        return zero
    return hardness


@inline
def yields(g, p, hardness, zero, one):
    """Return 1 for a point that has a dent, or is about to have one, otherwise 0."""
    if hardness is None:
        return zero
    return one if g < zero or (g <= zero and p >= hardness) else zero


@inline
def landing(v, y, length, hardness, zero):
    """Return where a point comes to that a step has taken to the gap v: the proximal map. y: what
    `yields` returns of it; length: of the step, for a pressure of 1."""
    if hardness is None:
        return max(v, zero)
    if y > zero:
        return min(v, zero) + max(v - length * hardness, zero)
    return max(v, zero) + min(v + length * hardness, zero)


@inline
def at_contact(w, g, e, hardness, zero):
    """Return whether a point that is to come to w from g is at 0: by the step e it would, but for
    rounding, be there or beyond."""
    if hardness is None:
        return w <= zero or e <= -g
    return w == zero or (w > zero and e <= -g) or (w < zero and e >= -g)
