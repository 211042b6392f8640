"""Kernels of constrained conjugate gradients on the pressure.

Local slabs: pressure iterate q >= 0, contact = {q > 0}; w = S q + h - offset, the gap up to a constant; t the search direction. The
constant is the mean of w in contact, `shift`: e = w - shift is the gap, and in contact it is what is left to be done. x is scratch,
rows from 0. Sums are in double precision over rows. Where the surface ends within the grid, `inside` is the shape of this rank's part
of it; beyond it q = 0 and w = S q - offset.
"""

from .jit import kernel


@kernel
def press(g, q, x, p0, inside, i0, i1):
    """q = p0 + x where the gap is closed (x = K u), no tension, 0 elsewhere; returns the sum of q."""
    zero = q.dtype.type(0)
    total = 0.0
    for i in range(i0, i1):
        s = zero
        m = inside[1] if i < inside[0] else 0
        q[i, m:] = zero
        for j in range(m):
            v = p0 + x[i - i0, j]
            v = v if g[i, j] <= zero and v > zero else zero
            q[i, j] = v
            s += v
        total += s
    return total


@kernel
def gradient(w, q, x, i0, i1, shift):
    """x = e in contact, 0 elsewhere."""
    zero = q.dtype.type(0)
    for i in range(i0, i1):
        for j in range(q.shape[1]):
            x[i - i0, j] = w[i, j] - shift if q[i, j] > zero else zero


@kernel
def conjugate(t, q, x, i0, i1, b):
    """t <- x + b t in contact, 0 elsewhere; returns the sum of x and the number of points in contact."""
    zero = q.dtype.type(0)
    total = 0.0
    contact = 0
    for i in range(i0, i1):
        s = zero
        for j in range(q.shape[1]):
            touching = q[i, j] > zero
            t[i, j] = x[i - i0, j] + b * t[i, j] if touching else zero
            s += x[i - i0, j] if touching else zero
            contact += 1 if touching else 0
        total += s
    return total, 1.0 * contact


@kernel
def direct(t, w, q, x, i0, i1, shift, a, b, c):
    """t <- a e + b t - c in contact, 0 elsewhere, also to x; returns the sums of e t and t."""
    zero = q.dtype.type(0)
    ET = T = 0.0
    for i in range(i0, i1):
        et = s = zero
        for j in range(q.shape[1]):
            e = w[i, j] - shift
            v = a * e + b * t[i, j] - c if q[i, j] > zero else zero
            t[i, j] = v
            x[i - i0, j] = v
            et += e * v
            s += v
        ET += et
        T += s
    return ET, T


@kernel
def respond(q, x, i0, i1):
    """Of x = S t: its sum in contact, and the number of points in contact."""
    zero = q.dtype.type(0)
    R = 0.0
    contact = 0
    for i in range(i0, i1):
        s = zero
        for j in range(q.shape[1]):
            touching = q[i, j] > zero
            s += x[i - i0, j] if touching else zero
            contact += 1 if touching else 0
        R += s
    return R, 1.0 * contact


@kernel
def advance(q, t, w, x, i0, i1, shift, tau, kick, inside):
    """q <- max(q - tau t, 0) in contact; where the gap out of contact is negative, q = -kick e; also to x.

    Returns the sum of q and the number of points taken into contact.
    """
    zero = q.dtype.type(0)
    total = 0.0
    taken = 0
    for i in range(i0, i1):
        s = zero
        m = inside[1] if i < inside[0] else 0
        x[i - i0, m:] = zero
        for j in range(m):
            e = w[i, j] - shift
            touching = q[i, j] > zero
            v = q[i, j] - tau * t[i, j] if touching else -kick * e
            v = zero if v < zero else v
            taken += 1 if not touching and v > zero else 0
            q[i, j] = v
            x[i - i0, j] = v
            s += v
        total += s
    return total, 1.0 * taken


@kernel
def respace(q, w, h, x, i0, i1, scale, offset):
    """q <- scale q and w = scale x + h - offset, x = S q before scaling; returns the sum of w in contact and of contact points."""
    zero = q.dtype.type(0)
    total = 0.0
    contact = 0
    for i in range(i0, i1):
        s = zero
        m = h.shape[1] if i < h.shape[0] else 0
        for j in range(m, q.shape[1]):
            w[i, j] = scale * x[i - i0, j] - offset
        for j in range(m):
            v = scale * q[i, j]
            q[i, j] = v
            r = scale * x[i - i0, j] + h[i, j] - offset
            w[i, j] = r
            s += r if v > zero else zero
            contact += 1 if v > zero else 0
        total += s
    return total, 1.0 * contact


@kernel
def close(q, w, g, p, shift, inside):
    """The admissible state: p = q, g = 0 in contact and max(e, 0) elsewhere; e itself beyond the surface.

    Returns sums: e^2 in contact, e^2 where negative out of contact, points in contact, g.
    """
    zero = q.dtype.type(0)
    EE = NEGATIVE = CONTACT = GAP = 0.0
    for i in range(q.shape[0]):
        ee = negative = gap = zero
        contact = 0
        m = inside[1] if i < inside[0] else 0
        for j in range(m, q.shape[1]):
            g[i, j] = w[i, j] - shift
            p[i, j] = zero
        for j in range(m):
            e = w[i, j] - shift
            touching = q[i, j] > zero
            below = e < zero and not touching
            ee += e * e if touching else zero
            negative += e * e if below else zero
            contact += 1 if touching else 0
            d = zero if touching or below else e
            g[i, j] = d
            p[i, j] = q[i, j]
            gap += d
        EE += ee
        NEGATIVE += negative
        CONTACT += contact
        GAP += gap
    return EE, NEGATIVE, CONTACT, GAP
