"""Kernels of damped dynamics: one pass before and one after the Fourier transform.

Letters, of fields: local slabs (n_loc, n_y). Gaps are in g_rms a, pressures in E* g_rms.

=======  ===========================================================================================
g        gap, >= 0
p        pressure
d        displacement of the last time step, a velocity
x        change of g on the rows of a pass; K times it after the transform
a, b     coefficients of the step: d <- b d - a p
A, F     contact {g <= 0 and p > 0}; the rest, which is free
inside   shape (rows, points) of this rank's part of the surface: its first rows and points
=======  ===========================================================================================

Beyond a surface that ends there is no wall, and g is the displacement u itself. Inside a row sums
are in the precision of the fields, over rows in double precision.
"""

from typing import NamedTuple

from .jit import kernel


class DynamicsSums(NamedTuple):
    """Sums over points: p^2 on F and everywhere, p d, d^2, d x, points in contact, gap."""

    rr: float
    pp: float
    pd: float
    dd: float
    dx: float
    contact: float
    gap: float


@kernel
def verlet_step(g, p, d, x, i0, i1, a, b, inside):
    """Set d <- b d - a p, g <- g + d, and g = d = 0 where a point hits the wall; x: g's change."""
    zero = g.dtype.type(0)
    for i in range(i0, i1):
        g_i = g[i]
        p_i = p[i]
        d_i = d[i]
        x_i = x[i - i0]
        inner = inside[1] if i < inside[0] else 0
        for j in range(g.shape[1]):
            v = b * d_i[j] - a * p_i[j]
            g_new = g_i[j] + v
            hit = j < inner and g_new <= zero
            x_i[j] = -g_i[j] if hit else v
            g_i[j] = zero if hit else g_new
            d_i[j] = zero if hit else v


@kernel
def update_pressure(g, p, d, x, i0, i1, inside):
    """Set p <- p + x, x being K times the change of g; return the DynamicsSums."""
    zero = g.dtype.type(0)
    RR = PP = PD = DD = DX = CONTACT = GAP = 0.0
    for i in range(i0, i1):
        g_i = g[i]
        p_i = p[i]
        d_i = d[i]
        x_i = x[i - i0]
        rr = pp = pd = dd = dx = gap = zero
        contact = 0
        inner = inside[1] if i < inside[0] else 0
        for j in range(inner):
            p_new = p_i[j] + x_i[j]
            p_i[j] = p_new
            touching = g_i[j] <= zero and p_new > zero
            pp += p_new * p_new
            rr += zero if touching else p_new * p_new
            pd += p_new * d_i[j]
            dd += d_i[j] * d_i[j]
            dx += d_i[j] * x_i[j]
            gap += g_i[j]
            contact += 1 if touching else 0
        for j in range(inner, g.shape[1]):
            p_new = p_i[j] + x_i[j]
            p_i[j] = p_new
            pp += p_new * p_new
            rr += p_new * p_new
            pd += p_new * d_i[j]
            dd += d_i[j] * d_i[j]
            dx += d_i[j] * x_i[j]
        RR += rr
        PP += pp
        PD += pd
        DD += dd
        DX += dx
        GAP += gap
        CONTACT += contact
    return DynamicsSums(RR, PP, PD, DD, DX, CONTACT, GAP)
