"""The two row passes of the default solver: lines 1 to 3 and line 6 of its algorithm.

The lines are those of the box in docs/method.md, "The iteration":

    1  z    = M r                                 projected_step, and multilevel.py before it
    2  d    = max(g - alpha z - beta d, 0) - g    projected_step
    3  d    = max(g - alpha z, 0) - g             the same with beta = 0 and coupling = 0
    4  K d, <d, K d>                              the columns of the transform, spectral.py
    5  s    = -<p, d>/<d, K d>                    solvers/bpx.py, of these sums
    6  g, p = g + s d, p + s K d                  update_state

Letters, of fields: local slabs (n_loc, n_y), of one pass only its rows from i0 on. Lengths in the
plane are in grid spacings a, gaps in g_rms a, pressures in E* g_rms.

=============  ===================================================================================
g              gap, >= 0; g < 0 is the depth of a dent (only with a hardness)
p              pressure
A, t           active set {g <= 0, p > 0}, elastic contact; t: its indicator, 1 or 0
F              all other points; those that yield belong to it
plastic        1 where a point yields, else 0 (yielding.py)
r              p on F, less H where a point yields; 0 on A
z              M r, the preconditioned residual: compliance (r + coupling P z_1)
z_1            the same on level 1, (rows + 2, m) with halo rows
d              last step of g, stored in half the bits (bfloat16.py); PROJECTED marks a point that
               the projection put on g = 0: its step is -g, and the next search takes 0 for it
d_row, d_ij    what d stands for, in full precision: the spectrum is that of the stored step
alpha, beta    step lengths along z and along the last step
s              step length along d
Kd             K d on the rows of a pass
law            law of attraction, None without one (numba then drops it): p is the pressure of
               the wall, and what adhesive_rows.py calls y takes the place of K d
H              hardness, None without one (numba then drops all that depends on it)
compliance     1/K of the shortest wave, about
i, j; J        row and point of the grid; row of level 1, counted from its halo row
n; m           points of a row; of a row of level 1
inside         shape (rows, points) of this rank's part of the surface: its first rows and points
transfer       tables between the grid and level 1: J_x and f_x of the rows, mode, J_y and f_y of
               the columns, factor (multilevel.py)
=============  ===================================================================================

Beyond the surface there is no wall: g is the displacement u itself and every point is in F. Each
row has two parts with a loop of their own: a single loop for both would not be vectorised.
"""

from typing import NamedTuple

import numpy as np

from .adhesive_rows import add_change, work_of_step
from .atomic import add
from .bfloat16 import decode, encode
from .jit import inline, kernel, points_inside
from .multilevel import combine_rows, interpolate_row, restrict_row, rows_beside
from .transforms import load_rows, store_rows
from .yielding import at_contact, landing, limit, yields


class UpdateSums(NamedTuple):
    """Sums over points of some rows, in this order: r is p on F, less H where a point yields; pp:
    p^2, where it yields r^2 + H^2; rd, dKd, rKd: on F; contact: in A or yielding; gap: without
    dents; attraction, stiffening: of `add_change`.
    """

    rr: float
    pp: float
    rd: float
    dKd: float
    rKd: float
    contact: float
    gap: float
    yielded: float
    attraction: float
    stiffening: float

    @classmethod
    def total(cls, parts):
        """Return the sums of all passes together; parts: (passes, sums), perhaps no pass."""
        return cls(*np.add.reduce(parts).tolist())


@kernel
def search_passes(
    passes,
    shares,
    turns,
    rows,
    scratch,
    sums,
    g,
    p,
    d,
    z_1,
    transfer,
    step,
    H,
    inside,
    law,
    work,
    transforms,
):
    """Make the step d on the rows of some passes and transform these rows: lines 1 to 3.

    Every thread calls this, and takes shares by `turns`, their common counter; `shares`: first pass
    of each and end, `passes`: of rows. `rows` (transforms.py) and `scratch` (two separate rows) are
    of one thread. `sums`, `work`: of each pass, from `projected_step` and `work_of_step`.
    """
    share = add(turns, 0, 1)
    while share < shares.shape[0]:
        for k in range(shares[share, 0], shares[share, 1]):
            i0 = passes[k, 0]
            i1 = passes[k, 1]
            sums[k, 0], sums[k, 1] = projected_step(
                g, p, d, rows[0], i0, i1, z_1, transfer, step, H, inside, scratch
            )
            if law is not None:
                work[k, 0], work[k, 1] = work_of_step(law, g, rows[0], i0, i1, inside)
            if transforms:
                store_rows(rows[1], i0, i1)
        share = add(turns, 0, 1)


@kernel
def update_passes(
    passes,
    shares,
    turns,
    rows,
    scratch,
    first_rows,
    sums,
    g,
    p,
    d,
    s,
    spectra,
    coarse,
    transfer,
    H,
    inside,
    law,
):
    """Transform rows of K d back (if `spectra`) and set g += s d, p += s K d, pass by pass: line 6.

    Threads as in `search_passes`. Restricts to level 1: `first_rows` (shares, 3, m) gets what a
    share's first pass adds to the coarse row of the pass before, for `join_shares`. `sums`:
    UpdateSums.
    """
    gathered, shared = scratch
    zero = g.dtype.type(0)
    share = add(turns, 0, 1)
    while share < shares.shape[0]:
        first = shares[share, 0]
        for k in range(first, shares[share, 1]):
            i0 = passes[k, 0]
            i1 = passes[k, 1]
            if spectra:
                load_rows(rows[1], i0, i1)
            of_slab = i0 if d.shape[0] == g.shape[0] else 0
            d_rows = d[of_slab : of_slab + i1 - i0]
            attraction = stiffening = 0.0
            if law is not None:
                attraction, stiffening = add_change(law, g, d_rows, rows[0], s, i0, i1, inside)
            update_state(
                g,
                p,
                d_rows,
                rows[0],
                s,
                i0,
                i1,
                coarse,
                shared,
                transfer,
                H,
                inside,
                gathered,
                sums[k],
            )
            sums[k, 8] = attraction
            sums[k, 9] = stiffening
            top = transfer[0][i0]
            bottom = transfer[0][i1 - 1] + 1
            for c in range(3):
                target = first_rows[share, c] if k == first else coarse[c, top]
                for j in range(target.shape[0]):
                    target[j] = shared[0, c, j] + (zero if k == first else target[j])
                    coarse[c, bottom, j] = shared[1, c, j]
        share = add(turns, 0, 1)


@kernel
def add_step(g, d):
    """Set g += d, the whole step as it is stored, on some rows: line 6 of the gap alone."""
    PROJECTED = encode(g.dtype.type(-np.inf))
    for i in range(g.shape[0]):
        for j in range(g.shape[1]):
            g[i, j] += -g[i, j] if d[i, j] == PROJECTED else decode(d[i, j])


@inline
def projected_step(g, p, d, d_rows, i0, i1, z_1, transfer, step, H, inside, scratch):
    """Make the step d = max(g - alpha z - beta d, 0) - g out of contact, 0 in contact, with z on
    the fly.

    coupling = 0: line 3; with a hardness the proximal map `landing`. step: (alpha, beta, coupling,
    compliance). d_rows: the stored step in full precision. Returns sums of <r, d> with the work of
    dents, and of deepening.
    """
    J_x, f_x, mode, J_y, f_y, _ = transfer
    alpha, beta, coupling, compliance = step
    n = g.shape[1]
    m = z_1.shape[1]
    zero = g.dtype.type(0)
    one = g.dtype.type(1)
    STILL = encode(zero)
    PROJECTED = encode(g.dtype.type(-np.inf))
    coarse_row = scratch[0][:m]
    Pz = scratch[1][:n]  # P z_1 on one row
    for j in range(n):
        Pz[j] = zero
    length = alpha * compliance
    H_or_0 = limit(H, zero)
    rd = 0.0
    deeper = 0.0
    for i in range(i0, i1):
        g_i = g[i]
        p_i = p[i]
        d_i = d[i]
        d_row = d_rows[i - i0]
        rd_i = zero
        deeper_i = zero
        if coupling > 0:  # line 1: the part of z that comes from level 1
            combine_rows(z_1, J_x[i], f_x[i], coarse_row)
            interpolate_row(coarse_row, Pz, mode, J_y, f_y)
        inner = points_inside(i, inside)
        for j in range(inner):
            d_last = zero if d_i[j] == PROJECTED else decode(d_i[j])
            plastic = yields(g_i[j], p_i[j], H, zero, one)
            r = p_i[j] - plastic * H_or_0
            in_A = g_i[j] <= zero and p_i[j] > zero and plastic == zero
            # line 2: d = max(g - alpha z - beta d, 0) - g, with z = compliance (r + coupling P z_1)
            free_gap = g_i[j] - length * (r + coupling * Pz[j]) - beta * d_last
            g_new = landing(free_gap, plastic, length, H, zero)
            stored = encode(g_new - g_i[j])
            on_wall = at_contact(g_new, g_i[j], decode(stored), H, zero)
            stored = PROJECTED if on_wall else stored
            stored = STILL if in_A else stored
            d_ij = -g_i[j] if stored == PROJECTED else decode(stored)
            rd_i += r * d_ij
            if H is not None:
                rd_i += H_or_0 * max((plastic + plastic - one) * (g_i[j] + d_ij), zero)
                deeper_i += max(-(g_i[j] + d_ij), zero) - max(-g_i[j], zero)
            d_i[j] = stored
            d_row[j] = d_ij
        for j in range(inner, np.uint64(n)):  # beyond the surface: no wall, so no projection
            stored = encode(-length * (p_i[j] + coupling * Pz[j]) - beta * decode(d_i[j]))
            d_ij = decode(stored)
            rd_i += p_i[j] * d_ij
            d_i[j] = stored
            d_row[j] = d_ij
        rd += rd_i
        deeper += deeper_i
    return rd, deeper


@inline
def update_state(g, p, d, Kd, s, i0, i1, coarse, shared, transfer, H, inside, gathered, sums):
    """Set g += s d and p += s K d, and restrict r, t and K d on F to level 1.

    i0 is the first row beside its coarse row. `coarse` (3, coarse rows + 2, m) gets the coarse rows
    that these rows have alone, `shared` (2, 3, m) the first one and the one after the last. Rows 0
    to 2 of `gathered` (6, >= n_y) are a complete coarse row, 3 to 5 what is there of the next.
    """
    J_x, f_x, mode, J_y, f_y, factor = transfer
    n = g.shape[1]
    for c in range(sums.shape[0]):
        sums[c] = 0.0
    J_first = J_x[i0]
    J_end = J_x[i1 - 1] + 1  # the one after the rows, which has parts of these, too
    for j in range(n):
        for c in range(3, 6):
            gathered[c, j] = 0
    start = i0
    for J in range(J_first, J_end + 1):
        end = start
        while end < i1 and J_x[end] == J:
            end += 1
        rr, pp, rd, dKd, rKd, contact, gap, yielded = _step_rows(
            g, p, d, Kd, s, i0, start, end, H, inside
        )
        sums[0] += rr
        sums[1] += pp
        sums[2] += rd
        sums[3] += dKd
        sums[4] += rKd
        sums[5] += contact
        sums[6] += gap
        sums[7] += yielded
        _gather_rows(g, p, Kd, i0, start, end, f_x, H, inside, gathered)
        for c in range(3):
            target = (
                shared[0, c] if J == J_first else (shared[1, c] if J == J_end else coarse[c, J])
            )
            restrict_row(gathered[c, :n], target, factor, mode, J_y, f_y)
        start = end


@inline
def _step_rows(g, p, d, Kd, s, i0, start, end, H, inside):
    """Set g += s d and p += s K d on rows start <= i < end; return their UpdateSums as a tuple."""
    zero = g.dtype.type(0)
    one = g.dtype.type(1)
    PROJECTED = encode(g.dtype.type(-np.inf))
    H_or_0 = limit(H, zero)
    rr = pp = rd = dKd = rKd = contact = gap = yielded = zero
    for i in range(start, end):
        inner = points_inside(i, inside)
        for j in range(inner):
            Kd_ij = Kd[i - i0, j]
            d_ij = -g[i, j] if d[i - i0, j] == PROJECTED else decode(d[i - i0, j])
            # line 6: g, p = g + s d, p + s K d
            g_new = g[i, j] + s * d_ij
            p_new = p[i, j] + s * Kd_ij
            g[i, j] = g_new
            p[i, j] = p_new
            closed = one if g_new <= zero else zero
            plastic = yields(g_new, p_new, H, zero, one)
            touches = closed if p_new > zero else zero
            t = zero if plastic > zero else touches
            free = one - t
            r = free * p_new - plastic * H_or_0
            Kd_free = free * Kd_ij
            contact += t + plastic
            rr += r * r
            pp += p_new * p_new if plastic == zero else r * r + H_or_0 * H_or_0
            rd += r * d_ij
            dKd += Kd_free * d_ij
            rKd += r * Kd_free
            dent = g_new if plastic > zero else zero
            gap += g_new - dent
            yielded += plastic
        for j in range(inner, np.uint64(g.shape[1])):
            Kd_ij = Kd[i - i0, j]
            d_ij = decode(d[i - i0, j])
            p_new = p[i, j] + s * Kd_ij
            g[i, j] += s * d_ij
            p[i, j] = p_new
            rr += p_new * p_new
            pp += p_new * p_new
            rd += p_new * d_ij
            dKd += Kd_ij * d_ij
            rKd += p_new * Kd_ij
    return rr, pp, rd, dKd, rKd, contact, gap, yielded


@inline
def _gather_rows(g, p, Kd, i0, start, end, f_x, H, inside, gathered):
    """Add up r, t and K d beside one coarse row, as `multilevel.gather_rows`, but with rows of one
    array: with more pointers the compiler gives up on vectors.
    """
    zero = g.dtype.type(0)
    one = g.dtype.type(1)
    H_or_0 = limit(H, zero)
    a, b, of_a, of_b, next_a, next_b = rows_beside(start, end, f_x, zero, one)
    inner = points_inside(a, inside)
    wall_b = one if points_inside(b, inside) > 0 else zero
    for j in range(inner):
        plastic_a = yields(g[a, j], p[a, j], H, zero, one)
        plastic_b = yields(g[b, j], p[b, j], H, zero, wall_b)
        t_a = one if (g[a, j] <= zero and p[a, j] > zero and plastic_a == zero) else zero
        t_b = wall_b if (g[b, j] <= zero and p[b, j] > zero and plastic_b == zero) else zero
        r_a = (one - t_a) * p[a, j] - plastic_a * H_or_0
        r_b = (one - t_b) * p[b, j] - plastic_b * H_or_0
        Kd_a = (one - t_a) * Kd[a - i0, j]
        Kd_b = (one - t_b) * Kd[b - i0, j]
        gathered[0, j] = gathered[3, j] + of_a * r_a + of_b * r_b
        gathered[1, j] = gathered[4, j] + of_a * t_a + of_b * t_b
        gathered[2, j] = gathered[5, j] + of_a * Kd_a + of_b * Kd_b
        gathered[3, j] = next_a * r_a + next_b * r_b
        gathered[4, j] = next_a * t_a + next_b * t_b
        gathered[5, j] = next_a * Kd_a + next_b * Kd_b
    for j in range(inner, np.uint64(g.shape[1])):
        Kd_a = Kd[a - i0, j]
        Kd_b = Kd[b - i0, j]
        gathered[0, j] = gathered[3, j] + of_a * p[a, j] + of_b * p[b, j]
        gathered[2, j] = gathered[5, j] + of_a * Kd_a + of_b * Kd_b
        gathered[3, j] = next_a * p[a, j] + next_b * p[b, j]
        gathered[5, j] = next_a * Kd_a + next_b * Kd_b
        gathered[1, j] = gathered[4, j]
        gathered[4, j] = zero
