"""From the solution on the decimated grid to a start on the finer one.

The displacement is interpolated; where the finer grid's heights poke through it, the solution
differs from the interpolation nearby. That difference v = u - P u_c is found without an FFT, by a
few projected gradient steps with the part of K that couples neighbours:

    v <- max(v - compliance (P p_c + K_near v), -g_c),    g_c = P u_c + h,    g = g_c + v.

A step that ends compliance times the hardness below -g_c makes a dent as deep as it is more.

Beyond the surface, where the grid goes on, nothing pokes through: h = 0 and g = u there, and v,
which follows the finer edge, is not bounded.
"""

import numpy as np

from .jit import inline, making_arrays

SWEEPS = 3  # gradient steps; each widens the halo by a row
# coarse rows needed beyond a rank's own: an axis may not be coarsened, or take a cubic
HALO = max(SWEEPS, SWEEPS // 2 + 2)
RING = SWEEPS + 1  # rows of every quantity that are kept


@making_arrays
def prolong_gap(u, p, h, g, fine_rows, coarse_rows, halved, compliance, stencil, most, nominal):
    """Make the gap g on this rank's rows; fine_rows: the first of them and how many there are on
    all ranks, coarse_rows: likewise.

    u, p: displacement and pressure of the coarse solution, h: initial gap; each the rows before
    this rank's own, those, and the rows after: HALO of u and p, SWEEPS of h. halved: whether the
    coarse grid has half as many points along x, along y; nominal: points along each axis that have
    an initial gap. stencil: K_near for the point itself, its neighbours along x, along y, and the
    diagonal ones. most: compliance times the hardness, inf without one. g may be h's own rows.
    Coarse point J lies on fine point 2 J; points in between get the cubic through the four nearest,
    (-1, 9, 9, -1)/16, of u, and the mean of two of p."""
    h_before, h, h_after = h
    start, n_x = fine_rows
    first, m_x = coarse_rows
    halve_x, halve_y = halved
    step_x = 2 if halve_x else 1
    rows, n = g.shape
    one, half = g.dtype.type(1), g.dtype.type(0.5)
    near, far = g.dtype.type(9.0 / 16.0), g.dtype.type(-1.0 / 16.0)
    s0, s1, s2, s3 = (
        one - compliance * stencil[0],
        -compliance * stencil[1],
        -compliance * stencil[2],
        -compliance * stencil[3],
    )
    m = u[1].shape[1]
    line = np.empty(m + 3, g.dtype)
    # Rows in rings, one more point on either side: first -g_c, then compliance P p, then v after 0,
    # 1, ... steps; the last is scratch.
    t = np.zeros(((SWEEPS + 3) * RING + 1, n + 2), g.dtype)
    for r in range(-SWEEPS, rows + SWEEPS):
        slot = (r + RING) % RING
        x, shift = start + r, first
        if x < 0:
            x, shift = x + n_x, first + m_x
        elif x >= n_x:
            x, shift = x - n_x, first - m_x
        inner = nominal[1] if x < nominal[0] else 0
        k = x // step_x - shift
        between = halve_x and x % 2 == 1
        if between:
            a, b, c, d = (_row(u, k - 1), _row(u, k), _row(u, k + 1), _row(u, k + 2))
            for J in range(m):
                line[J + 1] = near * (b[J] + c[J]) + far * (a[J] + d[J])
        else:
            line[1 : m + 1] = _row(u, k)
        _interpolate_row(line, t[slot], halve_y, near, far)
        v = 2 * RING + slot
        if inner > 0:
            a = h_before[r + SWEEPS] if r < 0 else (h[r] if r < rows else h_after[r - rows])
            for j in range(inner):
                g_c = t[slot, j + 1] + a[j]
                t[slot, j + 1] = -g_c
                t[v, j + 1] = max(min(-g_c, most), g.dtype.type(0))
        for j in range(inner, n):
            t[slot, j + 1] = -t[slot, j + 1]
            t[v, j + 1] = g.dtype.type(0)
        _wrap(t[v])
        if between:
            a, b = _row(p, k), _row(p, k + 1)
            for J in range(m):
                line[J + 1] = compliance * half * (a[J] + b[J])
        else:
            a = _row(p, k)
            for J in range(m):
                line[J + 1] = compliance * a[J]
        _interpolate_row(line, t[RING + slot], halve_y, half, g.dtype.type(0))
        for s in range(1, SWEEPS + 1):
            i = r - s
            if i >= s - SWEEPS:
                y = (start + i + n_x) % n_x
                inner = nominal[1] if y < nominal[0] else 0
                _relax(t, (s + 1) * RING, i, n, inner, most, s0, s1, s2, s3)
        i = r - SWEEPS
        if i >= 0:
            lowest, v = (i + RING) % RING, (SWEEPS + 2) * RING + (i + RING) % RING
            for j in range(n):
                g[i, j] = t[v, j + 1] - t[lowest, j + 1]


@making_arrays
def _row(field, k):
    """Return row k of a field: of own rows, or of those before and after."""
    before, own, after = field
    if k < 0:
        return before[before.shape[0] + k]
    if k >= own.shape[0]:
        return after[k - own.shape[0]]
    return own[k]


@making_arrays
def _interpolate_row(line, fine, halve_y, near, far):
    """Interpolate coarse points line[1:-2] along the row, fine[1:-1]."""
    n, m = fine.shape[0] - 2, line.shape[0] - 3
    if not halve_y:
        fine[1 : n + 1] = line[1 : m + 1]
        return
    line[0], line[m + 1], line[m + 2] = line[m], line[1], line[1 + 1 % m]
    for J in range(n // 2):
        fine[2 * J + 1] = line[J + 1]
        fine[2 * J + 2] = near * (line[J + 1] + line[J + 2]) + far * (line[J] + line[J + 3])
    fine[n] = line[m] if n % 2 else fine[n]


@inline
def _wrap(row):
    n = row.shape[0] - 2
    row[0], row[n + 1] = row[n], row[1]


@inline
def _relax(t, v, i, n, inner, most, s0, s1, s2, s3):
    """Make one step for row i, of which `inner` points are of the surface: t[v + ...] is the ring
    of its input."""
    a, b, c = v + (i - 1 + RING) % RING, v + (i + RING) % RING, v + (i + 1 + RING) % RING
    lowest, p, out, last = (
        (i + RING) % RING,
        RING + (i + RING) % RING,
        v + RING + (i + RING) % RING,
        t.shape[0] - 1,
    )
    for j in range(n + 2):
        t[last, j] = t[a, j] + t[c, j]
    for j in range(1, n + 1):
        t[out, j] = (
            s0 * t[b, j]
            + s1 * t[last, j]
            + s2 * (t[b, j - 1] + t[b, j + 1])
            + s3 * (t[last, j - 1] + t[last, j + 1])
            - t[p, j]
        )
    for j in range(1, inner + 1):
        t[out, j] = max(t[out, j], min(t[out, j] + most, t[lowest, j]))
    _wrap(t[out])
