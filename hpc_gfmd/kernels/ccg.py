"""Kernels of constrained conjugate gradients on the pressure.

Local slabs: pressure p >= 0 (the iterate), contact = {p > 0}; gap0 = S p + h - offset, the gap up
to a constant; t the search direction. The constant is the mean of gap0 in contact, `shift`: e =
gap0 - shift is the gap, and in contact it is what is left to be done. x is scratch, rows from 0.
Sums are in double precision over rows. Where the surface ends within the grid, `inside` is the
shape of this rank's part of it; beyond it p = 0 and gap0 = S p - offset.
"""

from .jit import kernel


@kernel
def start_pressure(g, p, x, p0, inside, i0, i1):
    """Set p = p0 + x where the gap is closed (x = K u), no tension, 0 elsewhere; returns the sum of
    p."""
    zero = p.dtype.type(0)
    total = 0.0
    for i in range(i0, i1):
        s = zero
        m = inside[1] if i < inside[0] else 0
        p[i, m:] = zero
        for j in range(m):
            v = p0 + x[i - i0, j]
            v = v if g[i, j] <= zero and v > zero else zero
            p[i, j] = v
            s += v
        total += s
    return total


@kernel
def gap_in_contact(gap0, p, x, i0, i1, shift):
    """Set x = e in contact, 0 elsewhere."""
    zero = p.dtype.type(0)
    for i in range(i0, i1):
        for j in range(p.shape[1]):
            x[i - i0, j] = gap0[i, j] - shift if p[i, j] > zero else zero


@kernel
def conjugate_direction(t, p, x, i0, i1, b):
    """Set t <- x + b t in contact, 0 elsewhere; returns the sum of x there."""
    zero = p.dtype.type(0)
    total = 0.0
    for i in range(i0, i1):
        s = zero
        for j in range(p.shape[1]):
            touching = p[i, j] > zero
            t[i, j] = x[i - i0, j] + b * t[i, j] if touching else zero
            s += x[i - i0, j] if touching else zero
        total += s
    return total


@kernel
def search_direction(t, gap0, p, x, i0, i1, shift, a, b, c):
    """Set t <- a e + b t - c in contact, 0 elsewhere, also to x; returns the sums of e t and t."""
    zero = p.dtype.type(0)
    ET = T = 0.0
    for i in range(i0, i1):
        et = s = zero
        for j in range(p.shape[1]):
            e = gap0[i, j] - shift
            v = a * e + b * t[i, j] - c if p[i, j] > zero else zero
            t[i, j] = v
            x[i - i0, j] = v
            et += e * v
            s += v
        ET += et
        T += s
    return ET, T


@kernel
def response_sum(p, x, i0, i1):
    """Return the sum of x = S t in contact."""
    zero = p.dtype.type(0)
    R = 0.0
    for i in range(i0, i1):
        s = zero
        for j in range(p.shape[1]):
            s += x[i - i0, j] if p[i, j] > zero else zero
        R += s
    return R


@kernel
def pressure_step(p, t, gap0, x, i0, i1, shift, tau, kick, inside):
    """Set p <- max(p - tau t, 0) in contact; where the gap out of contact is negative, p = -kick e;
    also to x.

    Returns the sum of p and the number of points taken into contact.
    """
    zero = p.dtype.type(0)
    total = 0.0
    taken = 0
    for i in range(i0, i1):
        s = zero
        m = inside[1] if i < inside[0] else 0
        x[i - i0, m:] = zero
        for j in range(m):
            e = gap0[i, j] - shift
            touching = p[i, j] > zero
            v = p[i, j] - tau * t[i, j] if touching else -kick * e
            v = zero if v < zero else v
            taken += 1 if not touching and v > zero else 0
            p[i, j] = v
            x[i - i0, j] = v
            s += v
        total += s
    return total, 1.0 * taken


@kernel
def new_gap(p, gap0, h, x, i0, i1, scale, offset):
    """Set p <- scale p and gap0 = scale x + h - offset, x = S p before scaling; returns the sum of
    gap0 in contact, contact points."""
    zero = p.dtype.type(0)
    total = 0.0
    contact = 0
    for i in range(i0, i1):
        s = zero
        m = h.shape[1] if i < h.shape[0] else 0
        for j in range(m, p.shape[1]):
            gap0[i, j] = scale * x[i - i0, j] - offset
        for j in range(m):
            v = scale * p[i, j]
            p[i, j] = v
            r = scale * x[i - i0, j] + h[i, j] - offset
            gap0[i, j] = r
            s += r if v > zero else zero
            contact += 1 if v > zero else 0
        total += s
    return total, 1.0 * contact


@kernel
def feasible_state(p, gap0, g, p_out, shift, inside, i0, i1):
    """Make the feasible state: p_out = p, g = 0 in contact and max(e, 0) elsewhere; e itself beyond
    the surface.

    Returns sums: e^2 in contact, e^2 where negative out of contact, g.
    """
    zero = p.dtype.type(0)
    EE = NEGATIVE = GAP = 0.0
    for i in range(i0, i1):
        ee = negative = gap = zero
        m = inside[1] if i < inside[0] else 0
        for j in range(m, p.shape[1]):
            g[i, j] = gap0[i, j] - shift
            p_out[i, j] = zero
        for j in range(m):
            e = gap0[i, j] - shift
            touching = p[i, j] > zero
            below = e < zero and not touching
            ee += e * e if touching else zero
            negative += e * e if below else zero
            gij = zero if touching or below else e
            g[i, j] = gij
            p_out[i, j] = p[i, j]
            gap += gij
        EE += ee
        NEGATIVE += negative
        GAP += gap
    return EE, NEGATIVE, GAP
