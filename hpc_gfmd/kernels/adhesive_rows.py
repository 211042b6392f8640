"""What an attraction adds to the row passes of the default solver and of the certificate.

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
    """Sum <t, d> and the change of phi that a full step d makes, over rows i0 <= i < i1.

    Parameters
    ----------
    law : Law
        Energy phi(g) and attraction t = phi'(g), in the precision of g.
    g : (n_loc, n_y)
        Gap before the step.
    d_rows : (>= i1 - i0, n_y)
        The step in full precision, from row i0 on.
    i0, i1 : int
        Local rows i0 <= i < i1.
    inside : (rows, points)
        Rows and points per row of this rank within the nominal area.

    Returns
    -------
    td : float
        <t, d>, t before the step.
    gained : float
        Sum of phi(g + d) - phi(g).
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
    """Turn K d into y = K d + (t(g + s d) - t(g))/s, in place, on rows i0 <= i < i1.

    g stays as it is; new gaps g + s d below 0 count as 0.

    Parameters
    ----------
    law : Law
        Energy phi(g) and attraction t = phi'(g), in the precision of g.
    g : (n_loc, n_y)
        Gap before the step.
    d : (>= i1 - i0, n_y), encoded
        The step from row i0 on, see bpx.py.
    Kd : (>= i1 - i0, n_y)
        K d from row i0 on; becomes y.
    s : float
        Step length, in the precision of g.
    i0, i1 : int
        Local rows i0 <= i < i1.
    inside : (rows, points)
        Rows and points per row of this rank within the nominal area.

    Returns
    -------
    t : float
        Sum of t at the new gaps.
    dt : float
        <d, t(g + s d) - t(g)>/s, by which <d, y> differs from <d, K d>.
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
    """Add the attraction t(g) to a field x, in place, on rows i0 <= i < i1.

    Gaps below 0 count as 0.

    Parameters
    ----------
    law : Law
        Energy phi(g) and attraction t = phi'(g), in the precision of x.
    g : (n_loc, n_y)
        Gap.
    x : (>= i1 - i0, n_y)
        Pressure of the body, from row i0 on; becomes that of the wall.
    i0, i1 : int
        Local rows i0 <= i < i1.
    inside : (rows, points)
        Rows and points per row of this rank within the nominal area.

    Returns
    -------
    t : float
        Sum of t.
    phi : float
        Sum of phi.
    """
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
    """Lower the gap by a constant on rows i0 <= i < i1, and change p by that of the attraction.

    Beyond the surface only g changes.

    Parameters
    ----------
    law : Law
        Energy phi(g) and attraction t = phi'(g), in the precision of g.
    g, p : (n_loc, n_y)
        Gap, no less than `by` on the surface, and pressure of the wall; become the new ones.
    by : float
        In the precision of g.
    i0, i1 : int
        Local rows i0 <= i < i1.
    inside : (rows, points)
        Rows and points per row of this rank within the nominal area.

    Returns
    -------
    float
        Sum of t at the new gaps.
    """
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
    """Set x = -phi''(g) out of contact, 0 in contact and beyond the surface, on rows i0 <= i < i1.

    Parameters
    ----------
    law : Law
        Energy phi(g) and attraction t = phi'(g), in the precision of g.
    g : (n_loc, n_y)
        Gap.
    closed : (n_loc, n_y)
        1 in contact, 0 elsewhere.
    x : (n_loc, n_y)
        Becomes the softening.
    i0, i1 : int
        Local rows i0 <= i < i1.
    inside : (rows, points)
        Rows and points per row of this rank within the nominal area.

    Returns
    -------
    total : float
        Sum of x.
    largest : float
        Largest x.
    """
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
    """Return how much a step along a direction changes the energy of the attraction.

    Parameters
    ----------
    law : Law
        Energy phi(g) and attraction t = phi'(g), in the precision of g.
    g, e : (n_loc, n_y)
        Gap and a direction; they stay as they are.
    length : float
        Length of the step, in the precision of g.
    i0, i1 : int
        Local rows i0 <= i < i1.
    inside : (rows, points)
        Rows and points per row of this rank within the nominal area.

    Returns
    -------
    float
        Sum of phi(g + length e) - phi(g) over these rows; new gaps below 0 count as 0.
    """
    zero = g.dtype.type(0)
    gained = 0.0
    for i in range(i0, i1):
        for j in range(points_inside(i, inside)):
            g_new = max(g[i, j] + length * e[i, j], zero)
            gained += energy_at(law, g_new) - energy_at(law, g[i, j])
    return gained


@kernel
def pull_along(law, g, e, length, i0, i1, inside):
    """Return how much a step along e changes the slope of the attraction's energy along e.

    Parameters
    ----------
    law : Law
        Energy phi(g) and attraction t = phi'(g), in double precision.
    g, e : (n_loc, n_y)
        Gap and a direction; they stay as they are.
    length : float
        Length of the step, in double precision.
    i0, i1 : int
        Local rows i0 <= i < i1.
    inside : (rows, points)
        Rows and points per row of this rank within the nominal area.

    Returns
    -------
    float
        <t(g + length e) - t(g), e> over these rows; gaps below 0 count as 0.
    """
    changed = 0.0
    for i in range(i0, i1):
        for j in range(points_inside(i, inside)):
            g_ij = np.float64(g[i, j])
            e_ij = np.float64(e[i, j])
            t_new = traction_at(law, max(g_ij + length * e_ij, 0.0))
            changed += (t_new - traction_at(law, max(g_ij, 0.0))) * e_ij
    return changed
