"""Kernels of damped dynamics: one pass before and one after the Fourier transform.

State, local slabs: gap g >= 0, pressure p, displacement d of the last time step (a velocity). Contact A = {g <= 0 and p > 0}, free
F = the rest; beyond a surface that ends, outside of `inside`, there is no wall, and g is the displacement u itself. Inside a row sums
are in the precision of the fields, over rows in double precision.
"""

from .jit import kernel


@kernel
def move(g, p, d, x, i0, i1, a, b, inside):
    """One time step d <- b d - a p, g <- g + d, on rows i0..i1; x (scratch, rows from 0): the change of g.

    The constraint g >= 0 stops what hits the wall (zero restitution): there g = 0 and d = 0, but x is how far it still went.
    """
    zero = g.dtype.type(0)
    for i in range(i0, i1):
        gi, pi, di, xi = g[i], p[i], d[i], x[i - i0]
        inner = inside[1] if i < inside[0] else 0
        for j in range(inner):
            v = b * di[j] - a * pi[j]
            new = gi[j] + v
            hit = new <= zero
            xi[j] = -gi[j] if hit else v
            gi[j] = zero if hit else new
            di[j] = zero if hit else v
        for j in range(inner, g.shape[1]):
            v = b * di[j] - a * pi[j]
            xi[j] = v
            gi[j] += v
            di[j] = v


@kernel
def settle(g, p, d, x, i0, i1, inside):
    """p <- p + x on rows i0..i1, x (scratch, rows from 0): K times the change of g.

    Returns sums: p^2 on F, p^2, p d, d^2, d x, points in contact, gap.
    """
    zero = g.dtype.type(0)
    RR = PP = PD = DD = DX = CONTACT = GAP = 0.0
    for i in range(i0, i1):
        gi, pi, di, xi = g[i], p[i], d[i], x[i - i0]
        rr = pp = pd = dd = dx = gap = zero
        contact = 0
        inner = inside[1] if i < inside[0] else 0
        for j in range(inner):
            q = pi[j] + xi[j]
            pi[j] = q
            touching = gi[j] <= zero and q > zero
            pp += q * q
            rr += zero if touching else q * q
            pd += q * di[j]
            dd += di[j] * di[j]
            dx += di[j] * xi[j]
            gap += gi[j]
            contact += 1 if touching else 0
        for j in range(inner, g.shape[1]):
            q = pi[j] + xi[j]
            pi[j] = q
            pp += q * q
            rr += q * q
            pd += q * di[j]
            dd += di[j] * di[j]
            dx += di[j] * xi[j]
        RR += rr
        PP += pp
        PD += pd
        DD += dd
        DX += dx
        GAP += gap
        CONTACT += contact
    return RR, PP, PD, DD, DX, CONTACT, GAP
