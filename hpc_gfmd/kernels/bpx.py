"""Kernels of the projected, preconditioned conjugate gradients: the rows before and after the
columns of a Fourier transform.

State, local slabs (n_loc, n_y): gap g >= 0, pressure p, last step d in bfloat16 (bfloat16.py): one
that is as rough costs no iteration. Contact A = {g <= 0 and p > 0}, the active
set; free F = the rest. With a hardness g < 0 is the depth of a dent, A the elastic contact, and
points that yield, which are free, have the residual p - hardness in place of p (yielding.py).
`rows` = (i0, i1) are the local rows of one pass, x is scratch (>= i1 - i0, n_y) that begins with
row i0; `transfer` is the tuple of tables that Transfer.tables has (parallel/coarsening.py).

Where the surface ends within the grid, `inside` is the shape of this rank's part of it (the first
rows and points of a slab). Beyond it there is no wall: g is the displacement u itself and does not
count. So every row has two parts, of which the second is empty on a periodic grid; each has a loop
of its own, because one for both would not use vectors.
"""

from typing import NamedTuple

import numpy as np

from .bfloat16 import decode, encode
from .jit import inline, kernel, points_inside
from .multilevel import combine_rows, interpolate_row, restrict_row
from .transforms import load_rows, store_rows
from .yielding import at_contact, landing, limit, yields


class UpdateSums(NamedTuple):
    """What `update_state` adds up over its rows, in its order; the kernel itself returns a plain
    tuple, which costs nothing to make.

    rr, pp: p^2 on F and everywhere, p less what yields; pd: p d on F; dx, px: d x and p x on F;
    contact: points that touch; gap; opening, closing: points that would open, and close, if the
    same step were made again; yielded: points of the contact."""

    rr: float
    pp: float
    pd: float
    dx: float
    px: float
    contact: float
    gap: float
    opening: float
    closing: float
    yielded: float

    @classmethod
    def total(cls, parts):
        """Add up those of the passes, (passes, sums), perhaps none."""
        return cls(*np.sum(parts, axis=0))


@kernel
def search_passes(passes, k0, k1, rows, scratch, found, g, p, d, z, transfer, step, limit, inside):
    """Make `projected_step` and transform its rows, pass after pass; found[k] gets what it returns.
    rows: see transforms.py."""
    for k in range(k0, k1):
        i0, i1 = passes[k, 0], passes[k, 1]
        found[k, 0], found[k, 1] = projected_step(
            g, p, d, rows[0], (i0, i1), z, transfer, step, limit, inside, scratch
        )
        store_rows(rows, i0, i1)


@kernel
def update_passes(
    passes, k0, k1, rows, scratch, first, found, g, p, d, s, comes, coarse, transfer, limit, inside
):
    """Transform rows back and make `update_state` of them, pass after pass; found[k] gets the sums.
    comes=False: the rows are there; d: of the slab, or of one pass.

    The coarse row that this pass and the next one share is the sum of both; `first` (3, m) gets the
    part of pass k0. scratch: that of `update_state`, and its `edges`.
    """
    work, edges = scratch
    zero = g.dtype.type(0)
    for k in range(k0, k1):
        i0, i1 = passes[k, 0], passes[k, 1]
        if comes:
            load_rows(rows, i0, i1)
        of_slab = i0 if d.shape[0] == g.shape[0] else 0
        state = (g, p, d[of_slab : of_slab + i1 - i0])
        sums = update_state(
            state, rows[0], s, (i0, i1), coarse, edges, transfer, limit, inside, work
        )
        for c in range(len(sums)):
            found[k, c] = sums[c]
        lo, hi = transfer[0][i0], transfer[0][i1 - 1] + 1
        for c in range(3):
            target = first[c] if k == k0 else coarse[c, lo]
            for j in range(target.shape[0]):
                target[j] = edges[0, c, j] + (zero if k == k0 else target[j])
                coarse[c, hi, j] = edges[1, c, j]


@kernel
def projected_step(g, p, d, x, rows, z_coarse, transfer, step, hardness, inside, scratch):
    """Write the next step to d and x: d = max(g - a z - b d, 0) - g on F, 0 on A. Returns <p, d>
    and by how much dents become deeper, in all.

    With a hardness a point may go through contact and yield, or come out of it (yielding.py); <p,
    d> then has the work of dents.

    step: (a, b, coupling, compliance). z = compliance (p + coupling P z_coarse) is formed on the
    fly; coupling = 0 gives a plain projected gradient step. d is stored roughly, and x is what it
    stands for: K is applied to what the gap is changed by. A point that is clipped, whose gap shall
    be 0, has a step of -infinity in d and none for the next time. scratch: (>= 2, n_y).
    """
    i0, i1 = rows
    k0, f_x, mode, j0, f, _ = transfer
    a, b, coupling, compliance = step
    n = g.shape[1]
    m = z_coarse.shape[1]
    zero = g.dtype.type(0)
    none, clipped = encode(zero), encode(g.dtype.type(-np.inf))
    row, fine = scratch[0, :m], scratch[1, :n]
    one, most = g.dtype.type(1), limit(hardness, zero)
    fine[:] = zero
    length = a * compliance
    total = deeper = 0.0
    for i in range(i0, i1):
        gi, pi, di, xi = g[i], p[i], d[i], x[i - i0]
        s = dents = zero
        if coupling > 0:
            combine_rows(z_coarse, k0[i], f_x[i], row)
            interpolate_row(row, fine, mode, j0, f)
        inner = points_inside(i, inside)
        for j in range(inner):
            last = zero if di[j] == clipped else decode(di[j])
            y = yields(gi[j], pi[j], hardness, zero, one)
            r = pi[j] - y * most
            v = gi[j] - length * (r + coupling * fine[j]) - b * last
            closed = gi[j] <= zero and pi[j] > zero and y == zero
            w = landing(v, y, length, hardness, zero)
            rough = encode(w - gi[j])
            rough = clipped if at_contact(w, gi[j], decode(rough), hardness, zero) else rough
            rough = none if closed else rough
            e = -gi[j] if rough == clipped else decode(rough)
            s += r * e
            if hardness is not None:
                s += most * max((y + y - one) * (gi[j] + e), zero)
                dents += max(-(gi[j] + e), zero) - max(-gi[j], zero)
            di[j] = rough
            xi[j] = e
        for j in range(inner, np.uint64(n)):
            rough = encode(-length * (pi[j] + coupling * fine[j]) - b * decode(di[j]))
            e = decode(rough)
            s += pi[j] * e
            di[j] = rough
            xi[j] = e
        total += s
        deeper += dents
    return total, deeper


@kernel
def update_state(state, x, s, rows, coarse, edges, transfer, hardness, inside, scratch):
    """Set g += s d, p += s x, and everything that the next step needs of the new state = (g, p, d);
    returns UpdateSums. d begins with row i0, as x.

    Restricts p on F, the indicator of A, and x on F to the coarser grid: coarse
    (3, coarse rows + 2, m) with halo gets the rows that belong to this pass alone, edges (2, 3, m)
    the first and the last, which it shares. scratch: (6, n_y).
    """
    g, p, _ = state
    i0, i1 = rows
    k0, f_x = transfer[:2]
    RR = PP = PD = DX = PX = CONTACT = GAP = OPENING = CLOSING = YIELDED = 0.0
    ends = k0[i0], k0[i1 - 1] + 1
    # 0-2: a complete coarse row, 3-5: what is there of the next one; p, indicator, x each
    scratch[3:6] = 0
    i = i0
    while i < i1:
        K = k0[i]
        end = i + 1
        while end < i1 and k0[end] == K:
            end += 1
        rr, pp, pd, dx, px, contact, gap, opening, closing, yielded = _update_rows(
            state, x, s, i0, i, end, hardness, inside
        )
        RR += rr
        PP += pp
        PD += pd
        DX += dx
        PX += px
        GAP += gap
        CONTACT += contact
        OPENING += opening
        CLOSING += closing
        YIELDED += yielded
        _gather_rows(g, p, x, i0, i, end, f_x, hardness, inside, scratch)
        _scatter_row(scratch, 0, g.shape[1], K, ends, edges, coarse, transfer)
        i = end
    _scatter_row(scratch, 3, g.shape[1], ends[1], ends, edges, coarse, transfer)
    return RR, PP, PD, DX, PX, CONTACT, GAP, OPENING, CLOSING, YIELDED


@inline
def _update_rows(state, x, s, i0, start, end, hardness, inside):
    """Make new g and p on rows start..end for `update_state`; returns their sums."""
    g, p, d = state
    zero, one, clipped = g.dtype.type(0), g.dtype.type(1), encode(g.dtype.type(-np.inf))
    rr = pp = pd = dx = px = contact = gap = opening = closing = yielded = zero
    most = limit(hardness, zero)
    for i in range(start, end):
        inner = points_inside(i, inside)
        for j in range(inner):
            y = x[i - i0, j]
            e = -g[i, j] if d[i - i0, j] == clipped else decode(d[i - i0, j])
            g_new = g[i, j] + s * e
            p_new = p[i, j] + s * y
            g_next, p_next = g_new + s * e, p_new + s * y
            g[i, j] = g_new
            p[i, j] = p_new
            closed = one if g_new <= zero else zero
            plastic = yields(g_new, p_new, hardness, zero, one)
            t = closed if p_new > zero else zero
            opening += t if p_next <= zero else zero
            t = zero if plastic > zero else t
            free = one - t
            p_free = free * p_new - plastic * most
            x_free = free * y
            contact += t + plastic
            closing += (one - closed) if g_next <= zero else zero
            rr += p_free * p_free
            pp += p_new * p_new if plastic == zero else p_free * p_free + most * most
            pd += p_free * e
            dx += x_free * e
            px += p_free * x_free
            dent = g_new if plastic > zero else zero
            gap += g_new - dent
            yielded += plastic
        for j in range(inner, np.uint64(g.shape[1])):
            y = x[i - i0, j]
            e = decode(d[i - i0, j])
            p_new = p[i, j] + s * y
            g[i, j] += s * e
            p[i, j] = p_new
            rr += p_new * p_new
            pp += p_new * p_new
            pd += p_new * e
            dx += y * e
            px += p_new * y
    return rr, pp, pd, dx, px, contact, gap, opening, closing, yielded


@inline
def _gather_rows(g, p, x, i0, start, end, f_x, hardness, inside, rows):
    """Add up the rows beside one coarse row, as `multilevel.gather_rows`: p on F, the indicator of
    A, x on F.

    A loop of its own, and rows of one array: with more pointers than this the compiler gives up on
    vectors.
    """
    n = g.shape[1]
    zero, one = g.dtype.type(0), g.dtype.type(1)
    most = limit(hardness, zero)
    # two rows, both of the surface or both beyond it
    if end == start + 2 and start + 1 != inside[0]:
        k = start + 1
        f0, f1 = f_x[start], f_x[k]
        inner = points_inside(k, inside)
        for j in range(inner):
            y0 = yields(g[start, j], p[start, j], hardness, zero, one)
            y1 = yields(g[k, j], p[k, j], hardness, zero, one)
            t0 = one if (g[start, j] <= zero and p[start, j] > zero and y0 == zero) else zero
            t1 = one if (g[k, j] <= zero and p[k, j] > zero and y1 == zero) else zero
            a0, a1 = (one - t0) * p[start, j] - y0 * most, (one - t1) * p[k, j] - y1 * most
            b0, b1 = (one - t0) * x[start - i0, j], (one - t1) * x[k - i0, j]
            rows[0, j] = rows[3, j] + (one - f0) * a0 + (one - f1) * a1
            rows[1, j] = rows[4, j] + (one - f0) * t0 + (one - f1) * t1
            rows[2, j] = rows[5, j] + (one - f0) * b0 + (one - f1) * b1
            rows[3, j] = f0 * a0 + f1 * a1
            rows[4, j] = f0 * t0 + f1 * t1
            rows[5, j] = f0 * b0 + f1 * b1
        for j in range(inner, np.uint64(n)):
            rows[0, j] = rows[3, j] + (one - f0) * p[start, j] + (one - f1) * p[k, j]
            rows[2, j] = rows[5, j] + (one - f0) * x[start - i0, j] + (one - f1) * x[k - i0, j]
            rows[3, j] = f0 * p[start, j] + f1 * p[k, j]
            rows[5, j] = f0 * x[start - i0, j] + f1 * x[k - i0, j]
            rows[1, j] = rows[4, j]
            rows[4, j] = zero
        return
    for c in range(3):
        for j in range(n):
            rows[c, j] = rows[c + 3, j]
            rows[c + 3, j] = zero
    for i in range(start, end):
        fi = f_x[i]
        inner = points_inside(i, inside)
        for j in range(inner):
            y = yields(g[i, j], p[i, j], hardness, zero, one)
            t = one if (g[i, j] <= zero and p[i, j] > zero and y == zero) else zero
            a = (one - t) * p[i, j] - y * most
            b = (one - t) * x[i - i0, j]
            rows[0, j] += (one - fi) * a
            rows[1, j] += (one - fi) * t
            rows[2, j] += (one - fi) * b
            rows[3, j] += fi * a
            rows[4, j] += fi * t
            rows[5, j] += fi * b
        for j in range(inner, np.uint64(n)):
            rows[0, j] += (one - fi) * p[i, j]
            rows[2, j] += (one - fi) * x[i - i0, j]
            rows[3, j] += fi * p[i, j]
            rows[5, j] += fi * x[i - i0, j]


@inline
def _scatter_row(rows, c0, n, K, ends, edges, coarse, transfer):
    """Restrict coarse row K, complete in rows[c0:c0 + 3, :n], along the other axis to where it
    belongs; ends: first and last of all."""
    _, _, mode, j0, f, factor = transfer
    for c in range(3):
        target = edges[0, c] if K == ends[0] else (edges[1, c] if K == ends[1] else coarse[c, K])
        restrict_row(rows[c0 + c, :n], target, factor, mode, j0, f)
