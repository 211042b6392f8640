"""Kernels of the projected, preconditioned GFMD solver: one pass before and one after the Fourier transform.

State, local slabs: gap g >= 0, pressure p, last step d. Contact A = {g <= 0 and p > 0}, free F = the rest.
"""

from .jit import inline, kernel
from .multilevel import combine_rows, interpolate_row, restrict_row

# columns of the sums that `update` returns
RR, PP, PD, DX, PX, CONTACT, GAP, LIFTING = range(8)


@kernel
def propose(g, p, d, x, i0, i1, z_coarse, k0, f_x, mode, j0, f, kap, w, a, b, rows):
    """Write the next step to d and x (scratch, rows from 0): d = max(g - a z - b d, 0) - g on F, 0 on A; returns <p, d>.

    z = kap (p + w P z_coarse) is formed on the fly; w = 0 gives a plain projected gradient step. rows: (2, n_y) scratch.
    """
    n = g.shape[1]
    m = z_coarse.shape[1]
    zero = g.dtype.type(0)
    row, fine = rows[0, :m], rows[1, :n]
    ak = a * kap
    total = 0.0
    for i in range(i0, i1):
        gi, pi, di, xi = g[i], p[i], d[i], x[i - i0]
        s = zero
        if w > 0:
            combine_rows(z_coarse, k0[i], f_x[i], row)
            interpolate_row(row, fine, mode, j0, f)
            for j in range(n):
                v = gi[j] - ak * (pi[j] + w * fine[j]) - b * di[j]
                e = max(v, zero) - gi[j]
                e = zero if (gi[j] <= zero and pi[j] > zero) else e
                s += pi[j] * e
                di[j] = e
                xi[j] = e
        else:
            for j in range(n):
                v = gi[j] - ak * pi[j] - b * di[j]
                e = max(v, zero) - gi[j]
                e = zero if (gi[j] <= zero and pi[j] > zero) else e
                s += pi[j] * e
                di[j] = e
                xi[j] = e
        total += s
    return total


@kernel
def update(g, p, d, x, s, i0, i1, coarse, first, last, k0, f_x, factor, mode, j0, f, rows):
    """g += s d, p += s x, and everything that the next step needs of the new state.

    Restricts p on F, the indicator of A, and x on F to the coarser grid: coarse (3, rows + 2, m) with halo gets the rows that
    belong to this pass alone, first and last (3, m) the two that it shares. rows: (6, n_y) scratch.
    Returns sums: p^2 on F, p^2, p d, on F: d x and p x, points in contact, gap, points with g <= 0 and p <= 0.
    """
    n = g.shape[1]
    zero = g.dtype.type(0)
    one = g.dtype.type(1)
    RRs = PPs = PDs = DXs = PXs = Cs = Gs = Ls = 0.0
    lo = k0[i0]
    hi = k0[i1 - 1] + 1
    rows[...] = zero
    here, after = 0, 3  # rows of the scratch that collect coarse row K, and K + 1: p, indicator, x each
    K = lo
    fresh = False  # whether nothing has been written to `after` since it was put down
    for i in range(i0, i1):
        while K < k0[i]:
            _put_down(rows, here, n, K, lo, hi, first, last, coarse, factor, mode, j0, f)
            if fresh:
                rows[after:after + 3] = zero
            here, after = after, here
            fresh = True
            K += 1
        w = f_x[i]
        rr, pp, pd, dx, px, nc, gs, nl = _update_row(
            g[i], p[i], d[i], x[i - i0], s, rows[here:here + 3], rows[after:after + 3], w, fresh, zero, one)
        fresh = fresh and w == zero
        RRs += rr
        PPs += pp
        PDs += pd
        DXs += dx
        PXs += px
        Gs += gs
        Cs += nc
        Ls += nl - nc
    _put_down(rows, here, n, K, lo, hi, first, last, coarse, factor, mode, j0, f)
    if fresh:
        rows[after:after + 3] = zero
    _put_down(rows, after, n, K + 1, lo, hi, first, last, coarse, factor, mode, j0, f)
    return RRs, PPs, PDs, DXs, PXs, Cs, Gs, Ls


@inline
def _update_row(g, p, d, x, s, here, after, w, fresh, zero, one):
    """One row of `update`: new g and p, its sums, and its share of the coarse rows before and after it."""
    n = g.shape[0]
    rr = pp = pd = dx = px = gs = nc = nl = zero
    for j in range(n):
        gg = g[j] + s * d[j]
        q = p[j] + s * x[j]
        g[j] = gg
        p[j] = q
        closed = one if gg <= zero else zero
        t = closed if q > zero else zero
        free = one - t
        pf = free * q
        xf = free * x[j]
        nc += t
        nl += closed
        rr += pf * pf
        pp += q * q
        pd += pf * d[j]
        dx += xf * d[j]
        px += pf * xf
        gs += gg
    # A second loop, and rows of one array: with more pointers than this the compiler gives up on vectors.
    p_here, t_here, x_here = here[0], here[1], here[2]
    p_after, t_after, x_after = after[0], after[1], after[2]
    if w == zero:
        for j in range(n):
            t = one if (g[j] <= zero and p[j] > zero) else zero
            free = one - t
            p_here[j] += free * p[j]
            t_here[j] += t
            x_here[j] += free * x[j]
    elif fresh:
        u = one - w
        for j in range(n):
            t = one if (g[j] <= zero and p[j] > zero) else zero
            a = (one - t) * p[j]
            b = (one - t) * x[j]
            p_here[j] += u * a
            t_here[j] += u * t
            x_here[j] += u * b
            p_after[j] = w * a
            t_after[j] = w * t
            x_after[j] = w * b
    else:
        u = one - w
        for j in range(n):
            t = one if (g[j] <= zero and p[j] > zero) else zero
            a = (one - t) * p[j]
            b = (one - t) * x[j]
            p_here[j] += u * a
            t_here[j] += u * t
            x_here[j] += u * b
            p_after[j] += w * a
            t_after[j] += w * t
            x_after[j] += w * b
    return rr, pp, pd, dx, px, nc, gs, nl


@inline
def _put_down(rows, here, n, K, lo, hi, first, last, coarse, factor, mode, j0, f):
    """Restrict a complete coarse row along the other axis to where it belongs."""
    for c in range(3):
        line = rows[here + c, :n]
        target = first[c] if K == lo else (last[c] if K == hi else coarse[c, K])
        restrict_row(line, target, factor, mode, j0, f)
