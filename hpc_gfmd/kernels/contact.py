"""Kernels of the projected, preconditioned GFMD solver: one pass before and one after the Fourier transform.

State, local slabs: gap g >= 0, pressure p, last step d. Contact A = {g <= 0 and p > 0}, free F = the rest.

Where the surface ends within the grid, `inside` is the shape of this rank's part of it (the first rows and points of a slab). Beyond it
there is no wall: g is the displacement u itself and does not count. So every row has two parts, of which the second is empty on a
periodic grid; each has a loop of its own, because one for both would not use vectors.
"""

from .jit import inline, kernel
from .multilevel import combine_rows, interpolate_row, restrict_row


@kernel
def propose(g, p, d, x, i0, i1, z_coarse, k0, f_x, mode, j0, f, kap, w, a, b, inside, rows):
    """Write the next step to d and x (scratch, rows from 0): d = max(g - a z - b d, 0) - g on F, 0 on A.

    Returns <p, d>.

    z = kap (p + w P z_coarse) is formed on the fly; w = 0 gives a plain projected gradient step. rows: (2, n_y) scratch.
    """
    n = g.shape[1]
    m = z_coarse.shape[1]
    zero = g.dtype.type(0)
    row, fine = rows[0, :m], rows[1, :n]
    ak = a * kap
    one = g.dtype.type(1)
    total = 0.0
    for i in range(i0, i1):
        gi, pi, di, xi = g[i], p[i], d[i], x[i - i0]
        s = zero
        inner = inside[1] if i < inside[0] else 0
        if w > 0:
            combine_rows(z_coarse, k0[i], f_x[i], row)
            interpolate_row(row, fine, mode, j0, f)
            for j in range(inner):
                v = gi[j] - ak * (pi[j] + w * fine[j]) - b * di[j]
                free = zero if (gi[j] <= zero and pi[j] > zero) else one
                e = free * (max(v, zero) - gi[j])
                s += pi[j] * e
                di[j] = e
                xi[j] = e
            for j in range(inner, n):
                e = -ak * (pi[j] + w * fine[j]) - b * di[j]
                s += pi[j] * e
                di[j] = e
                xi[j] = e
        else:
            for j in range(inner):
                v = gi[j] - ak * pi[j] - b * di[j]
                free = zero if (gi[j] <= zero and pi[j] > zero) else one
                e = free * (max(v, zero) - gi[j])
                s += pi[j] * e
                di[j] = e
                xi[j] = e
            for j in range(inner, n):
                e = -ak * pi[j] - b * di[j]
                s += pi[j] * e
                di[j] = e
                xi[j] = e
        total += s
    return total


@kernel
def update(g, p, d, x, s, closed, i0, i1, coarse, first, last, k0, f_x, factor, mode, j0, f, inside, rows):
    """g += s d, p += s x, and everything that the next step needs of the new state.

    Restricts p on F and closed p on A, the indicator of A, and x on F to the coarser grid: coarse (3, rows + 2, m) with halo gets the
    rows that belong to this pass alone, first and last (3, m) the two that it shares. rows: (7, n_y) scratch.
    Returns sums: p^2 on F, p^2, p d, on F: d x and p x, points in contact, gap; points that would open, and close, if the same step
    were made again.
    """
    n = g.shape[1]
    zero = g.dtype.type(0)
    one = g.dtype.type(1)
    RRs = PPs = PDs = DXs = PXs = Cs = Gs = Os = Ss = 0.0
    lo = k0[i0]
    hi = k0[i1 - 1] + 1
    rows[3:6] = zero  # rows 0-2: a complete coarse row, 3-5: what is there of the next one; p, indicator, x each
    i = i0
    while i < i1:
        K = k0[i]
        end = i + 1
        while end < i1 and k0[end] == K:
            end += 1
        rr, pp, pd, dx, px, nc, gs, no, ns = _advance(g, p, d, x, s, i0, i, end, inside, zero, one)
        RRs += rr
        PPs += pp
        PDs += pd
        DXs += dx
        PXs += px
        Gs += gs
        Cs += nc
        Os += no
        Ss += ns
        _gather(g, p, x, closed, i0, i, end, f_x, inside, rows, zero, one)
        _put_down(rows, 0, n, K, lo, hi, first, last, coarse, factor, mode, j0, f)
        i = end
    _put_down(rows, 3, n, hi, lo, hi, first, last, coarse, factor, mode, j0, f)
    return RRs, PPs, PDs, DXs, PXs, Cs, Gs, Os, Ss


@inline
def _advance(g, p, d, x, s, i0, start, end, inside, zero, one):
    """Rows start..end of `update`: new g and p, and their sums."""
    rr = pp = pd = dx = px = gs = nc = no = ns = zero
    for i in range(start, end):
        inner = inside[1] if i < inside[0] else 0
        for j in range(inner):
            y = x[i - i0, j]
            gg = g[i, j] + s * d[i, j]
            q = p[i, j] + s * y
            g_next, p_next = gg + s * d[i, j], q + s * y
            g[i, j] = gg
            p[i, j] = q
            touching = one if gg <= zero else zero
            t = touching if q > zero else zero
            free = one - t
            pf = free * q
            xf = free * y
            nc += t
            no += t if p_next <= zero else zero
            ns += (one - touching) if g_next <= zero else zero
            rr += pf * pf
            pp += q * q
            pd += pf * d[i, j]
            dx += xf * d[i, j]
            px += pf * xf
            gs += gg
        for j in range(inner, g.shape[1]):
            y = x[i - i0, j]
            q = p[i, j] + s * y
            g[i, j] += s * d[i, j]
            p[i, j] = q
            rr += q * q
            pp += q * q
            pd += q * d[i, j]
            dx += y * d[i, j]
            px += q * y
    return rr, pp, pd, dx, px, nc, gs, no, ns


@inline
def _gather(g, p, x, closed, i0, start, end, f_x, inside, rows, zero, one):
    """Add up the rows beside one coarse row, as `multilevel.gather_rows`: p on F and closed p on A, the indicator of A, x on F.

    A loop of its own, and rows of one array: with more pointers than this the compiler gives up on vectors.
    """
    n = g.shape[1]
    if end == start + 2 and start + 1 != inside[0]:  # two rows, both of the surface or both beyond it
        k = start + 1
        v, w = f_x[start], f_x[k]
        inner = inside[1] if k < inside[0] else 0
        for j in range(inner):
            t0 = one if (g[start, j] <= zero and p[start, j] > zero) else zero
            t1 = one if (g[k, j] <= zero and p[k, j] > zero) else zero
            a0, a1 = (closed * t0 + (one - t0)) * p[start, j], (closed * t1 + (one - t1)) * p[k, j]
            b0, b1 = (one - t0) * x[start - i0, j], (one - t1) * x[k - i0, j]
            rows[0, j] = rows[3, j] + (one - v) * a0 + (one - w) * a1
            rows[1, j] = rows[4, j] + (one - v) * t0 + (one - w) * t1
            rows[2, j] = rows[5, j] + (one - v) * b0 + (one - w) * b1
            rows[3, j] = v * a0 + w * a1
            rows[4, j] = v * t0 + w * t1
            rows[5, j] = v * b0 + w * b1
        for j in range(inner, n):
            rows[0, j] = rows[3, j] + (one - v) * p[start, j] + (one - w) * p[k, j]
            rows[2, j] = rows[5, j] + (one - v) * x[start - i0, j] + (one - w) * x[k - i0, j]
            rows[3, j] = v * p[start, j] + w * p[k, j]
            rows[5, j] = v * x[start - i0, j] + w * x[k - i0, j]
            rows[1, j] = rows[4, j]
            rows[4, j] = zero
        return
    for c in range(3):
        for j in range(n):
            rows[c, j] = rows[c + 3, j]
            rows[c + 3, j] = zero
    for i in range(start, end):
        w = f_x[i]
        inner = inside[1] if i < inside[0] else 0
        for j in range(inner):
            t = one if (g[i, j] <= zero and p[i, j] > zero) else zero
            a = (closed * t + (one - t)) * p[i, j]
            b = (one - t) * x[i - i0, j]
            rows[0, j] += (one - w) * a
            rows[1, j] += (one - w) * t
            rows[2, j] += (one - w) * b
            rows[3, j] += w * a
            rows[4, j] += w * t
            rows[5, j] += w * b
        for j in range(inner, n):
            rows[0, j] += (one - w) * p[i, j]
            rows[2, j] += (one - w) * x[i - i0, j]
            rows[3, j] += w * p[i, j]
            rows[5, j] += w * x[i - i0, j]


@inline
def _put_down(rows, c0, n, K, lo, hi, first, last, coarse, factor, mode, j0, f):
    """Restrict a complete coarse row along the other axis to where it belongs."""
    for c in range(3):
        target = first[c] if K == lo else (last[c] if K == hi else coarse[c, K])
        restrict_row(rows[c0 + c, :n], target, factor, mode, j0, f, rows[6])
