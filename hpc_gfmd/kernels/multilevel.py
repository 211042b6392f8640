"""Transfer between a grid and the next coarser one, and the sweep over the coarsest levels, which
one rank holds.

Along an axis of n points that is coarsened to m = ceil(n/2), coarse point J sits at fine position J
n/m: fine point i lies between J0 = floor(i m/n) and J0 + 1 with weight f = i m/n - J0 of the
latter. P is linear interpolation, R = (m/n)^2 P^T (full weighting).

`transfer` is the tuple of tables that Transfer.tables has (parallel/coarsening.py): k0, f_x:
coarse row (halo counted) and weight f of each own fine row; mode of the column axis: 0 not
coarsened, 1 even n (f = 0, 1/2, 0, ...), 2 general (tables j0, f); factor (m/n)^2. Arrays with halo
rows have one row before and one after the rank's own rows.
"""

import numpy as np

from .jit import inline, making_arrays


@inline
def restrict_row(fine, coarse, factor, mode, j0, f):
    """Set coarse = factor P^T fine along one row."""
    one = fine.dtype.type(1)
    n = fine.shape[0]
    m = coarse.shape[0]
    if mode == 1:
        half = factor * fine.dtype.type(0.5)
        before = half * fine[n - 1]
        # even and odd points are read together: vectors of every second point alone would be
        # gathered
        for J in range(m):
            after = half * fine[2 * J + 1]
            coarse[J] = factor * fine[2 * J] + after + before
            before = after
    elif mode == 0:
        for J in range(m):
            coarse[J] = factor * fine[J]
    else:
        coarse[:] = fine.dtype.type(0)
        for i in range(n):
            a = j0[i]
            b = a + 1
            if b == m:
                b = 0
            v = factor * fine[i]
            coarse[a] += v * (one - f[i])
            coarse[b] += v * f[i]


@inline
def interpolate_row(coarse, fine, mode, j0, f):
    """Set fine = P coarse along one row."""
    one, half = fine.dtype.type(1), fine.dtype.type(0.5)
    n = fine.shape[0]
    m = coarse.shape[0]
    if mode == 1:
        for J in range(m - 1):
            a = coarse[J]
            fine[2 * J] = a
            fine[2 * J + 1] = half * (a + coarse[J + 1])
        fine[n - 2] = coarse[m - 1]
        fine[n - 1] = half * (coarse[m - 1] + coarse[0])
    elif mode == 0:
        for J in range(m):
            fine[J] = coarse[J]
    else:
        for i in range(n):
            a = j0[i]
            b = a + 1
            if b == m:
                b = 0
            fine[i] = coarse[a] * (one - f[i]) + coarse[b] * f[i]


@inline
def combine_rows(coarse, k, f, out):
    """Set out = (1 - f) coarse[k] + f coarse[k + 1]."""
    m = out.shape[0]
    one = out.dtype.type(1)
    if f == 0.0:
        for J in range(m):
            out[J] = coarse[k, J]
    else:
        for J in range(m):
            out[J] = coarse[k, J] * (one - f) + coarse[k + 1, J] * f


@making_arrays
def restrict_level(fine, coarse, transfer, i0, i1):
    """Set coarse = factor P^T fine for all fields: fine (c, rows + 2, n) with valid own rows;
    coarse (c, rows' + 2, m), halo included.

    Makes the coarse rows that own rows i0..i1 lie on or after; i0 opens a coarse row. With the last
    row also the one that comes next; coarse rows that no fine row lies beside are left as they are.
    Rows are added up first: that is contiguous, and leaves half as many rows to restrict along the
    other axis.
    """
    k0, f_x, mode, j0, f, factor = transfer
    c, rows, n = fine.shape
    here = np.empty(n, fine.dtype)
    after = np.empty(n, fine.dtype)
    before = i0
    while before > 0 and k0[before - 1] == k0[max(i0 - 1, 0)]:
        before -= 1
    for k in range(c):
        after[:] = 0
        own = fine[k, 1 : rows - 1]
        if before < i0:
            gather_rows(own, k0, f_x, before, here, after)
        i = i0
        while i < i1:
            K = k0[i]
            i = gather_rows(own, k0, f_x, i, here, after)
            restrict_row(here, coarse[k, K], factor, mode, j0, f)
            if i == rows - 2:
                restrict_row(after, coarse[k, K + 1], factor, mode, j0, f)


@inline
def gather_rows(fine, k0, f_x, i, here, after):
    """Add up the rows i, i + 1, ... that lie beside the same coarse row: here = after + sum of (1 -
    f_x) row, after = sum of f_x row.

    Returns the row that comes next. There are two of them wherever the axis is halved: those take
    one pass.
    """
    rows, n = fine.shape
    end = i + 1
    while end < rows and k0[end] == k0[i]:
        end += 1
    one = here.dtype.type(1)
    if end == i + 2:
        a, b = fine[i], fine[i + 1]
        fa, fb = f_x[i], f_x[i + 1]
        for j in range(n):
            here[j] = after[j] + (one - fa) * a[j] + (one - fb) * b[j]
            after[j] = fa * a[j] + fb * b[j]
        return end
    for j in range(n):
        here[j] = after[j]
        after[j] = here.dtype.type(0)
    for r in range(i, end):
        a, fa = fine[r], f_x[r]
        for j in range(n):
            here[j] += (one - fa) * a[j]
            after[j] += fa * a[j]
    return end


@making_arrays
def smooth_level(rt, z_coarse, out, weight, damping, transfer, nominal, i0, i1):
    """Set out = r/(weight + damping t) + P z_coarse on own rows i0..i1; rt: (>=2, rows + 2, n).
    Returns <r, out>, <x, out>, <r, r>, <t, t>, <r, t>, <t, s> and <r, s>.

    x is the third field of rt if there is one; s is the product of nominal = (rows,), (n,). out may
    be rt[0].
    """
    s_x, s_y = nominal
    k0, f_x, mode, j0, f, _ = transfer
    n = rt.shape[2]
    has_x = rt.shape[0] > 2
    m = z_coarse.shape[1]
    row = np.empty(m, rt.dtype)
    fine = np.empty(n, rt.dtype)
    zero = rt.dtype.type(0)
    rz = xz = rr = tt = cross = ts = rs = 0.0
    for h in range(i0 + 1, i1 + 1):
        combine_rows(z_coarse, k0[h - 1], f_x[h - 1], row)
        interpolate_row(row, fine, mode, j0, f)
        out_r = r_r = t_t = r_t = t_s = r_s = zero
        for j in range(n):
            r, t = rt[0, h, j], rt[1, h, j]
            z = r / (weight + damping * t) + fine[j]
            out_r += r * z
            r_r += r * r
            t_t += t * t
            r_t += r * t
            t_s += t * s_y[j]
            r_s += r * s_y[j]
            fine[j] = z
        rz += out_r
        rr += r_r
        tt += t_t
        cross += r_t
        ts += s_x[h - 1] * t_s
        rs += s_x[h - 1] * r_s
        if has_x:
            out_x = zero
            for j in range(n):
                out_x += rt[2, h, j] * fine[j]
            xz += out_x
        for j in range(n):
            out[h, j] = fine[j]
    return rz, xz, rr, tt, cross, ts, rs


@making_arrays
def sweep_coarsest(r, t, shapes, offsets, weights, softness, damping, mode, at):
    """Sweep the levels that one rank holds completely, in place: r of the finest of them becomes z.

    r, t: flat storage of all levels; level k is r[offsets[k]:...] of shape shapes[k]; r and t of
    level 0 are given. mode: flat, added to z on level `at` times its product with r there. Returns
    the sums over levels of softness times <r, r>, <t, t> and <r, t>, each as a sum over the points
    of level 0, and the mean of r.
    """
    levels = shapes.shape[0]
    rr = tt = rt = 0.0
    N = shapes[0, 0] * shapes[0, 1]
    mean = 0.0
    for k in range(levels - 1):
        n_x, n_y = shapes[k]
        m_x, m_y = shapes[k + 1]
        a, b = offsets[k], offsets[k + 1]
        _restrict(r[a : a + n_x * n_y].reshape(n_x, n_y), r[b : b + m_x * m_y].reshape(m_x, m_y))
        _restrict(t[a : a + n_x * n_y].reshape(n_x, n_y), t[b : b + m_x * m_y].reshape(m_x, m_y))
    amplitude = r.dtype.type(0)
    for i in range(mode.shape[0]):
        amplitude += mode[i] * r[offsets[at] + i]
    for k in range(levels - 1, -1, -1):
        n_x, n_y = shapes[k]
        a = offsets[k]
        weight = weights[k]
        here, contact = r[a : a + n_x * n_y], t[a : a + n_x * n_y]
        mean = here.mean() if k == levels - 1 else mean
        s = u = v = 0.0
        for i in range(here.shape[0]):
            s += here[i] * here[i]
            u += contact[i] * contact[i]
            v += here[i] * contact[i]
            here[i] = here[i] / (weight + damping * contact[i])
        share = N / (n_x * n_y) * softness[k]
        rr += s * share
        tt += u * share
        rt += v * share
        if k < levels - 1:
            m_x, m_y = shapes[k + 1]
            b = offsets[k + 1]
            _interpolate(
                r[b : b + m_x * m_y].reshape(m_x, m_y), r[a : a + n_x * n_y].reshape(n_x, n_y)
            )
        if k == at:
            for i in range(mode.shape[0]):
                r[a + i] += amplitude * mode[i]
    return rr, tt, rt, mean


@making_arrays
def _axis(n, m, dtype_of):
    """Make mode and tables of one axis of a level that one rank holds completely."""
    mode = 0 if n == m else (1 if n == 2 * m and n > 2 else 2)
    j0 = np.empty(n, np.int32)
    f = np.empty(n, dtype_of.dtype)
    for i in range(n):
        j0[i] = (i * m) // n
        f[i] = ((i * m) % n) / n
    return mode, j0, f


@making_arrays
def _restrict(fine, coarse):
    n_x, n_y = fine.shape
    m_x, m_y = coarse.shape
    mode, j0, f = _axis(n_y, m_y, fine)
    _, k0, g = _axis(n_x, m_x, fine)
    factor = fine.dtype.type((m_x / n_x) * (m_y / n_y))
    here = np.empty(n_y, fine.dtype)
    after = np.zeros(n_y, fine.dtype)
    i = 0
    while i < n_x:
        K = k0[i]
        i = gather_rows(fine, k0, g, i, here, after)
        restrict_row(here, coarse[K], factor, mode, j0, f)
    if g[n_x - 1] > 0:  # the last row lies between the last coarse row and the first
        line = np.empty(m_y, fine.dtype)
        restrict_row(after, line, factor, mode, j0, f)
        for J in range(m_y):
            coarse[0, J] += line[J]


@making_arrays
def _interpolate(coarse, fine):
    """Add P coarse to fine."""
    one = fine.dtype.type(1)
    n_x, n_y = fine.shape
    m_x, m_y = coarse.shape
    mode, j0, f = _axis(n_y, m_y, fine)
    _, k0, g = _axis(n_x, m_x, fine)
    row = np.empty(m_y, fine.dtype)
    temp = np.empty(n_y, fine.dtype)
    for i in range(n_x):
        K = k0[i]
        L = K + 1 if K + 1 < m_x else 0
        a = one - g[i]
        b = g[i]
        for J in range(m_y):
            row[J] = coarse[K, J] * a + coarse[L, J] * b
        interpolate_row(row, temp, mode, j0, f)
        for j in range(n_y):
            fine[i, j] += temp[j]
