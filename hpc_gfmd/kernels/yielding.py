"""Points at which the pressure is the hardness: functions of a point for kernels.

hardness is None where there is none: numba then compiles a variant in which both are constants, so
that nothing is left of them.
"""

from .jit import inline


@inline
def limit(hardness, zero):
    """The pressure of a point that yields."""
    if hardness is None:
        return zero
    return hardness


@inline
def yields(g, p, hardness, zero, one):
    """1 for a point that has a dent, or is about to have one, otherwise 0."""
    if hardness is None:
        return zero
    return one if g < zero or (g <= zero and p >= hardness) else zero
