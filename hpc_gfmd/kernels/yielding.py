"""Points at which the pressure is the hardness: functions of a point for kernels.

Letters: g gap, p pressure, H hardness. H is None where there is none: numba then compiles a variant
in which `limit` and `yields` are constants, so that nothing is left of them. Zero and one come in
the precision of the fields.
"""

from .jit import inline


@inline
def limit(H, zero):
    """Return the pressure of a point that yields: H, or 0 without a hardness.

    Parameters
    ----------
    H : float or None
        Hardness.
    zero : float
        0 in the precision of the fields.

    Returns
    -------
    float
        H or zero.
    """
    if H is None:
        return zero
    return H


@inline
def yields(g, p, H, zero, one):
    """Return 1 if a point yields, else 0: it has a dent (g < 0), or touches with p >= H.

    Parameters
    ----------
    g, p : float
        Gap and pressure of the point.
    H : float or None
        Hardness; without one no point yields.
    zero, one : float
        0 and 1 in the precision of the fields.

    Returns
    -------
    float
        one or zero.
    """
    if H is None:
        return zero
    return one if g < zero or (g <= zero and p >= H) else zero


@inline
def landing(v, plastic, length, H, zero):
    """Return the gap of a point after a step: the proximal map.

    Parameters
    ----------
    v : float
        Gap to which the step would take the point if there were no surface.
    plastic : float
        What `yields` returned for the point before the step.
    length : float
        Length of the step for a pressure of 1.
    H : float or None
        Hardness.
    zero : float
        0 in the precision of the fields.

    Returns
    -------
    float
        At least 0 without a hardness; below 0: the depth of a dent.
    """
    if H is None:
        return max(v, zero)
    if plastic > zero:
        return min(v, zero) + max(v - length * H, zero)
    return max(v, zero) + min(v + length * H, zero)


@inline
def at_contact(w, g, e, H, zero):
    """Return whether a step takes a point to g = 0, up to the rounding of the stored step.

    Parameters
    ----------
    w : float
        Gap after the step, as `landing` returns it.
    g : float
        Gap before the step.
    e : float
        Step of the gap as it is stored, in fewer digits.
    H : float or None
        Hardness.
    zero : float
        0 in the precision of the fields.

    Returns
    -------
    bool
        True also if the stored step reaches or crosses g = 0 although w does not.
    """
    if H is None:
        return w <= zero or e <= -g
    return w == zero or (w > zero and e <= -g) or (w < zero and e >= -g)
