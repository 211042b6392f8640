"""The two row passes of the default solver, letters as in hpc_gfmd/kernels/bpx.py.

A thread of `step_rows` and `restrict_state` has a coarse column c, of `change_state` a fine one,
and goes down a strip of rows. Coarse row J, halo rows counted, lies on fine row 2 (J - 1).
"""

import numpy as np
from numba import cuda

from .bfloat16 import PROJECTED, STILL, decode, encode
from .launch import HALF, ONE, STRIP, THREADS, ZERO, blocks_of, launch, partial_sums, sum_of_block

SUMS = 10  # of UpdateSums
QUARTER = np.float32(0.25)  # factor of a transfer to half the points along both axes


def step_on_rows(g, p, d, d_rows, i0, i1, z_1, step):
    """Make the step d on rows i0 <= i < i1; return the sums <r, d> of the blocks."""
    blocks = blocks_of(i1 - i0, z_1.shape[1])
    partial = partial_sums(g, blocks, 1)
    launch(step_rows, blocks, THREADS, g, p, d, d_rows, i0, i1, z_1, *step, partial)
    return partial


def change_on_rows(g, p, d_rows, Kd, s, i0, i1):
    """Set g += s d and p += s K d on rows i0 <= i < i1; return the UpdateSums of the blocks."""
    blocks = blocks_of(i1 - i0, g.shape[1])
    partial = partial_sums(g, blocks, SUMS)
    launch(change_state, blocks, THREADS, g, p, d_rows, Kd, s, i0, i1, partial)
    return partial


def restrict_on_rows(g, p, Kd, i0, i1, goes_on, coarse):
    """Restrict r, t and K d of rows i0 <= i < i1 to level 1.

    goes_on: whether the first coarse row holds already what the rows before add to it. The coarse
    row after the last gets what these rows add to it.
    """
    blocks = blocks_of(i1 - i0, coarse.shape[2])
    launch(restrict_state, blocks, THREADS, g, p, Kd, i0, i1, goes_on, coarse)


@cuda.jit(device=True)
def projected_point(g, p, stored, Pz, length, coupling, beta):
    """Return the step d = max(g - alpha z - beta d, 0) - g of a point, as it is stored; 0 in A.

    g, p: gap and pressure; stored: last step; Pz: P z_1; length: alpha compliance.
    """
    d_last = ZERO if stored == PROJECTED else decode(stored)
    free_gap = g - length * (p + coupling * Pz) - beta * d_last
    g_new = max(free_gap, ZERO)
    new = encode(g_new - g)
    if g_new <= ZERO or decode(new) <= -g:
        new = PROJECTED
    if g <= ZERO and p > ZERO:
        new = STILL
    return new


@cuda.jit(device=True)
def step_of(stored, g):
    """Return what a stored step of a point stands for; g: its gap."""
    return -g if stored == PROJECTED else decode(stored)


@cuda.jit(device=True)
def step_point(g, p, d, d_rows, i, j, i0, Pz, length, coupling, beta):
    """Make the step of point (i, j) and return r d."""
    g_ij = g[i, j]
    p_ij = p[i, j]
    stored = projected_point(g_ij, p_ij, d[i, j], Pz, length, coupling, beta)
    d_ij = step_of(stored, g_ij)
    d[i, j] = stored
    d_rows[i - i0, j] = d_ij
    return p_ij * d_ij


@cuda.jit
def step_rows(g, p, d, d_rows, i0, i1, z_1, alpha, beta, coupling, compliance, partial):
    """Make the step d on rows i0 <= i < i1; partial[:, 0] gets <r, d>.

    Points of A, where r is 0, have a step of 0.
    """
    shared = cuda.shared.array(THREADS, np.float64)
    m = z_1.shape[1]
    c = cuda.blockIdx.x * THREADS + cuda.threadIdx.x
    start = i0 + cuda.blockIdx.y * STRIP
    end = min(start + STRIP, i1)
    length = alpha * compliance
    rd = ZERO
    if c < m:
        c_next = c + 1 if c + 1 < m else 0
        j = 2 * c
        left = ZERO
        right = ZERO
        left_below = ZERO
        right_below = ZERO
        if coupling > ZERO:
            left_below = z_1[start // 2 + 1, c]
            right_below = z_1[start // 2 + 1, c_next]
        for i in range(start, end, 2):
            left = left_below
            right = right_below
            if coupling > ZERO:
                left_below = z_1[i // 2 + 2, c]
                right_below = z_1[i // 2 + 2, c_next]
            left_mean = HALF * (left + left_below)
            right_mean = HALF * (right + right_below)
            mean = HALF * (left + right)
            mean_below = HALF * (left_mean + right_mean)
            rd += step_point(g, p, d, d_rows, i, j, i0, left, length, coupling, beta)
            rd += step_point(g, p, d, d_rows, i, j + 1, i0, mean, length, coupling, beta)
            rd += step_point(g, p, d, d_rows, i + 1, j, i0, left_mean, length, coupling, beta)
            rd += step_point(g, p, d, d_rows, i + 1, j + 1, i0, mean_below, length, coupling, beta)
    sum_of_block(rd, shared, partial, 0)


@cuda.jit
def change_state(g, p, d_rows, Kd, s, i0, i1, partial):
    """Set g += s d and p += s K d on rows i0 <= i < i1; partial gets their UpdateSums."""
    shared = cuda.shared.array(THREADS, np.float64)
    j = cuda.blockIdx.x * THREADS + cuda.threadIdx.x
    start = i0 + cuda.blockIdx.y * STRIP
    end = min(start + STRIP, i1)
    rr = pp = rd = dKd = rKd = contact = gap = opening = closing = ZERO
    if j < g.shape[1]:
        for i in range(start, end):
            g_old = g[i, j]
            Kd_ij = Kd[i - i0, j]
            d_ij = step_of(d_rows[i - i0, j], g_old)
            g_new = g_old + s * d_ij
            p_new = p[i, j] + s * Kd_ij
            g[i, j] = g_new
            p[i, j] = p_new
            closed = g_new <= ZERO
            touches = closed and p_new > ZERO
            opening += ONE if touches and p_new + s * Kd_ij <= ZERO else ZERO
            closing += ONE if not closed and g_new + s * d_ij <= ZERO else ZERO
            contact += ONE if touches else ZERO
            r = ZERO if touches else p_new
            Kd_free = ZERO if touches else Kd_ij
            rr += r * r
            pp += p_new * p_new
            rd += r * d_ij
            dKd += Kd_free * d_ij
            rKd += r * Kd_free
            gap += g_new
    sum_of_block(rr, shared, partial, 0)
    sum_of_block(pp, shared, partial, 1)
    sum_of_block(rd, shared, partial, 2)
    sum_of_block(dKd, shared, partial, 3)
    sum_of_block(rKd, shared, partial, 4)
    sum_of_block(contact, shared, partial, 5)
    sum_of_block(gap, shared, partial, 6)
    sum_of_block(opening, shared, partial, 7)
    sum_of_block(closing, shared, partial, 8)
    sum_of_block(ZERO, shared, partial, 9)


@cuda.jit(device=True)
def weighted_row(g, p, Kd, i, i0, c):
    """Return r, t and K d of row i beside coarse column c: point 2 c and half of its neighbours."""
    r = t = x = ZERO
    n = g.shape[1]
    for k in range(-1, 2):
        j = 2 * c + k
        if j < 0:
            j += n
        weight = ONE if k == 0 else HALF
        p_ij = p[i, j]
        if g[i, j] <= ZERO and p_ij > ZERO:
            t += weight
        else:
            r += weight * p_ij
            x += weight * Kd[i - i0, j]
    return r, t, x


@cuda.jit
def restrict_state(g, p, Kd, i0, i1, goes_on, coarse):
    """Restrict r, t and K d of rows i0 <= i < i1 to level 1, as `restrict_on_rows` describes."""
    c = cuda.blockIdx.x * THREADS + cuda.threadIdx.x
    start = i0 + cuda.blockIdx.y * STRIP
    end = min(start + STRIP, i1)
    if c >= coarse.shape[2]:
        return
    r = t = x = ZERO  # what the row above adds
    if start > i0:
        r, t, x = weighted_row(g, p, Kd, start - 1, i0, c)
        r *= HALF
        t *= HALF
        x *= HALF
    for i in range(start, end, 2):
        J = i // 2 + 1
        r_a, t_a, x_a = weighted_row(g, p, Kd, i, i0, c)
        r_b, t_b, x_b = weighted_row(g, p, Kd, i + 1, i0, c)
        r = QUARTER * (r + r_a + HALF * r_b)
        t = QUARTER * (t + t_a + HALF * t_b)
        x = QUARTER * (x + x_a + HALF * x_b)
        if goes_on and i == i0:
            r += coarse[0, J, c]
            t += coarse[1, J, c]
            x += coarse[2, J, c]
        coarse[0, J, c] = r
        coarse[1, J, c] = t
        coarse[2, J, c] = x
        r = HALF * r_b
        t = HALF * t_b
        x = HALF * x_b
    if end == i1:
        J = i1 // 2 + 1
        coarse[0, J, c] = QUARTER * r
        coarse[1, J, c] = QUARTER * t
        coarse[2, J, c] = QUARTER * x
