"""What an attraction adds to the row passes of the default solver and of the certificate:
equations (2) and (3) in docs/method.md.

With a law phi(g) (laws/, attraction.py) the solver's p is the pressure of the wall, r = w + t: w is
that of the body, t = phi'(g) the attraction. A step that changes w by s K d changes r by

    s y,    y = K d + (t(g + s d) - t(g))/s,

so that y takes the place of K d. Other letters are those of bpx.py; phi is in E* g_rms^2 a. Beyond
the surface (`inside`) there is no wall, and no attraction. Sums are in double precision whatever
the fields are.
"""

import numpy as np

from .attraction import curvature_at, energy_at, traction_at
from .bfloat16 import decode, encode
from .jit import kernel, points_inside


@kernel
def work_of_step(law, g, d_rows, i0, i1, inside):
    """Return sums of t d (t before the step) and phi(g + d) - phi(g); d_rows: the full-precision
    step, from row i0.
    """
    td = 0.0
    gained = 0.0
    for i in range(i0, i1):
        g_i = g[i]
        d_i = d_rows[i - i0]
        for j in range(points_inside(i, inside)):
            td += traction_at(law, g_i[j]) * d_i[j]
            gained += energy_at(law, g_i[j] + d_i[j]) - energy_at(law, g_i[j])
    return td, gained


@kernel
def add_change(law, g, d, Kd, s, i0, i1, inside):
    """Turn K d into y = K d + (t(g + s d) - t(g))/s, in place; return the sum of the new t, and <d,
    y> - <d, K d>. d (encoded), Kd: from row i0; gaps below 0 count as 0.
    """
    zero = g.dtype.type(0)
    PROJECTED = encode(g.dtype.type(-np.inf))
    t = 0.0
    dt = 0.0
    for i in range(i0, i1):
        g_i = g[i]
        for j in range(points_inside(i, inside)):
            stored = d[i - i0, j]
            d_ij = -g_i[j] if stored == PROJECTED else decode(stored)
            t_new = traction_at(law, max(g_i[j] + s * d_ij, zero))
            change = (t_new - traction_at(law, g_i[j])) / s
            Kd[i - i0, j] += change
            t += t_new
            dt += change * d_ij
    return t, dt


@kernel
def add_attraction(law, g, x, i0, i1, inside):
    """Add t(g) to x, the body's pressure from row i0 on, in place; return the sums of t and phi."""
    real = x.dtype.type
    zero = real(0)
    t = 0.0
    phi = 0.0
    for i in range(i0, i1):
        for j in range(points_inside(i, inside)):
            g_ij = max(real(g[i, j]), zero)
            t_ij = traction_at(law, g_ij)
            x[i - i0, j] += t_ij
            t += t_ij
            phi += energy_at(law, g_ij)
    return t, phi


@kernel
def shift_gap(law, g, p, by, i0, i1, inside):
    """Lower the gap by a constant, `by` at most on the surface, change p as t; return sum of t."""
    zero = g.dtype.type(0)
    t = 0.0
    for i in range(i0, i1):
        inner = points_inside(i, inside)
        for j in range(inner):
            g_new = max(g[i, j] - by, zero)
            t_new = traction_at(law, g_new)
            p[i, j] += t_new - traction_at(law, g[i, j])
            g[i, j] = g_new
            t += t_new
        for j in range(inner, np.uint64(g.shape[1])):
            g[i, j] -= by
    return t


@kernel
def softening(law, g, closed, x, i0, i1, inside):
    """Set x = -phi''(g) where `closed` is 0, else 0; return its sum and its maximum."""
    zero = g.dtype.type(0)
    one = g.dtype.type(1)
    total = 0.0
    largest = zero
    for i in range(i0, i1):
        inner = points_inside(i, inside)
        for j in range(inner):
            x[i, j] = (closed[i, j] - one) * curvature_at(law, max(g[i, j], zero))
            total += x[i, j]
            largest = max(largest, x[i, j])
        for j in range(inner, np.uint64(g.shape[1])):
            x[i, j] = zero
    return total, largest


@kernel
def gain_along(law, g, e, length, i0, i1, inside):
    """Return the sum of phi(g + length e) - phi(g) over rows; new gaps below 0 count as 0."""
    zero = g.dtype.type(0)
    gained = 0.0
    for i in range(i0, i1):
        for j in range(points_inside(i, inside)):
            g_new = max(g[i, j] + length * e[i, j], zero)
            gained += energy_at(law, g_new) - energy_at(law, g[i, j])
    return gained


@kernel
def pull_along(law, g, e, length, i0, i1, inside):
    """Return <t(g + length e) - t(g), e> over rows; gaps below 0 count as 0."""
    changed = 0.0
    for i in range(i0, i1):
        for j in range(points_inside(i, inside)):
            g_ij = np.float64(g[i, j])
            e_ij = np.float64(e[i, j])
            t_new = traction_at(law, max(g_ij + length * e_ij, 0.0))
            changed += (t_new - traction_at(law, max(g_ij, 0.0))) * e_ij
    return changed
