"""Kernels of damped dynamics: one pass before and one after the Fourier transform.

State, local slabs: gap g >= 0, pressure p, displacement d of the last time step (a velocity).
Contact A = {g <= 0 and p > 0}, free F = the rest; beyond a surface that ends, outside of `inside`,
there is no wall, and g is the displacement u itself. Inside a row sums are in the precision of the
fields, over rows in double precision.
"""

from typing import NamedTuple

from .jit import kernel


class DynamicsSums(NamedTuple):
    """Sums over points, as `update_pressure` returns them.

    Attributes
    ----------
    rr, pp : float
        p^2 on F, and everywhere.
    pd, dd, dx : float
        p d, d^2, and d x.
    contact : float
        Number of points in contact.
    gap : float
        Of the surface.
    """

    rr: float
    pp: float
    pd: float
    dd: float
    dx: float
    contact: float
    gap: float


@kernel
def verlet_step(g, p, d, x, i0, i1, a, b, inside):
    """Make one time step, d <- b d - a p, g <- g + d, on rows i0..i1; x (scratch, rows from 0): the
    change of g.

    The constraint g >= 0 stops what hits the wall (zero restitution): there g = 0 and d = 0, but x
    is how far it still went.
    """
    zero = g.dtype.type(0)
    for i in range(i0, i1):
        gi, pi, di, xi = g[i], p[i], d[i], x[i - i0]
        inner = inside[1] if i < inside[0] else 0
        for j in range(g.shape[1]):
            v = b * di[j] - a * pi[j]
            g_new = gi[j] + v
            hit = j < inner and g_new <= zero
            xi[j] = -gi[j] if hit else v
            gi[j] = zero if hit else g_new
            di[j] = zero if hit else v


@kernel
def update_pressure(g, p, d, x, i0, i1, inside):
    """Set p <- p + x on rows i0..i1, x (scratch, rows from 0): K times the change of g.

    Returns DynamicsSums.
    """
    zero = g.dtype.type(0)
    RR = PP = PD = DD = DX = CONTACT = GAP = 0.0
    for i in range(i0, i1):
        gi, pi, di, xi = g[i], p[i], d[i], x[i - i0]
        rr = pp = pd = dd = dx = gap = zero
        contact = 0
        inner = inside[1] if i < inside[0] else 0
        for j in range(inner):
            p_new = pi[j] + xi[j]
            pi[j] = p_new
            touching = gi[j] <= zero and p_new > zero
            pp += p_new * p_new
            rr += zero if touching else p_new * p_new
            pd += p_new * di[j]
            dd += di[j] * di[j]
            dx += di[j] * xi[j]
            gap += gi[j]
            contact += 1 if touching else 0
        for j in range(inner, g.shape[1]):
            p_new = pi[j] + xi[j]
            pi[j] = p_new
            pp += p_new * p_new
            rr += p_new * p_new
            pd += p_new * di[j]
            dd += di[j] * di[j]
            dx += di[j] * xi[j]
        RR += rr
        PP += pp
        PD += pd
        DD += dd
        DX += dx
        GAP += gap
        CONTACT += contact
    return DynamicsSums(RR, PP, PD, DD, DX, CONTACT, GAP)
