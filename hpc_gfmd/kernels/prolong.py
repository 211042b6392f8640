"""From the solution on the decimated grid to a start on the finer one ("Nested iteration" in
docs/method.md).

The displacement is interpolated; where the finer grid's heights poke through it, the solution
differs from the interpolation nearby. That difference v = u - P u_c is computed without an FFT, by
a few projected gradient steps s with the part of K that couples neighbours:

    v <- max(v - c_s (P p_c + K_near v), -g_c),    g_c = P u_c + h,    g = g_c + v.

Their lengths c_s are those of Chebyshev's iteration for the waves that the coarse grid lacks. With
a hardness H, a step that ends more than c_s H below -g_c makes a dent of the excess.

Beyond the surface, in the padding of the grid, nothing pokes through: h = 0 and g = u there, and v,
which follows the finer edge, is not bounded.

Letters. Gaps are in g_rms a of the fine grid, pressures in E* g_rms, K in 1/a.

============  ====================================================================================
i, j          row and column of a fine point, of this rank; x: row of the whole grid
J             column of a coarse point, k its row. Coarse point (k, J) lies on fine point (2 k, 2 J)
u, p          displacement and pressure of the coarse solution
h             initial gap
g             gap on the fine grid, the result
v             what the steps change, see above
============  ====================================================================================
"""

import math
from itertools import product

import numpy as np

from .jit import inline, kernel

SWEEPS = 3  # gradient steps; each widens the halo by a row
# The steps are made for symbols of the stencil from this share of the highest one, if the lowest is
# less or negative, as with stiff thin coatings. Insensitive: with coatings 10 and 100 times stiffer
# than the body, half a point and two points thick, pairs change by up to 3 % from 0.15 to 0.4.
LOWEST = 0.25
# coarse rows needed beyond a rank's own: an axis may not be coarsened, or take a cubic
HALO = max(SWEEPS, SWEEPS // 2 + 2)
RING = SWEEPS + 1  # rows of every quantity that are kept


def gradient_steps(stencil, halved):
    """Return c_s of the gradient steps, the largest first: Chebyshev's for the range of the
    stencil's symbol over the waves that the coarse grid lacks.
    """
    itself, along_x, along_y, diagonal = stencil.tolist()
    # The symbol is linear in the cosines of both phases, so that its extremes are at corners.
    symbol = [
        itself + 2 * along_x * x + 2 * along_y * y + 4 * diagonal * x * y
        for x, y in product((-1, 0, 1), repeat=2)
        if (halved[0] and x <= 0) or (halved[1] and y <= 0)
    ]
    highest = max(symbol)
    lowest = max(min(symbol), LOWEST * highest)
    roots = [math.cos(math.pi * (s + 0.5) / SWEEPS) for s in range(SWEEPS)]
    return [2 / (highest + lowest - (highest - lowest) * root) for root in roots]


def prolong_gap(u, p, h, g, fine_rows, coarse_rows, halved, steps, stencil, hardness, nominal):
    """Compute the gap g on some rows of the fine grid from the solution on the decimated grid.

    Between coarse points u is cubic, (-1, 9, 9, -1)/16, and p the mean. u, p, h: also rows before
    and after this rank's, HALO of coarse fields, SWEEPS of h. g may be h. fine_rows, coarse_rows:
    first row of this rank, rows of all. steps: c_s. stencil: K at a point, neighbours along x, y,
    diagonal. hardness: perhaps inf.
    """
    itself, along_x, along_y, diagonal = stencil.tolist()
    couplings = np.array(
        [
            (1 - c * itself, -c * along_x, -c * along_y, -c * diagonal, c, c * hardness)
            for c in steps
        ],
        g.dtype,
    )
    # Rows in rings, with one more point on either side: -g_c, then P p, then v after
    # 0, 1, ... steps; the last row is scratch.
    ring = np.zeros(((SWEEPS + 3) * RING + 1, g.shape[1] + 2), g.dtype)
    line = np.empty(u[1].shape[1] + 3, g.dtype)
    numbers = np.array([*fine_rows, *coarse_rows, *halved, *nominal], np.int64)
    _prolong(u, p, h, g, numbers, couplings, ring, line)


@kernel
def _prolong(u, p, h, g, numbers, couplings, ring, line):
    """Fill g as `prolong_gap`; numbers: its fine_rows, coarse_rows, halved and nominal; couplings:
    of v and P p in each step, and its deepest dent.
    """
    real = g.dtype.type
    start, n_x, first_coarse, m_x, halve_x, halve_y, surface_rows, surface_points = numbers
    rows = g.shape[0]
    n = g.shape[1]
    zero = real(0)
    one = real(1)
    near = real(9.0 / 16.0)
    far = real(-1.0 / 16.0)
    half = real(0.5)
    deepest = couplings[0, 5]
    for i in range(-SWEEPS, rows + SWEEPS):
        slot = (i + RING) % RING
        x = start + i
        shift = first_coarse
        if x < 0:
            x += n_x
            shift += m_x
        elif x >= n_x:
            x -= n_x
            shift -= m_x
        inner = surface_points if x < surface_rows else 0
        k = (x // 2 if halve_x else x) - shift
        between = halve_x and x % 2 == 1
        lowest = ring[slot]
        v = ring[2 * RING + slot]
        _coarse_line(u, k, between, one, near, far, line)
        _interpolate_row(line, lowest, halve_y, near, far)
        for j in range(1, n + 1):
            lowest[j] = -lowest[j]
            v[j] = zero
        if inner > 0:
            heights = h[0] if i < 0 else (h[1] if i < rows else h[2])
            row = i + SWEEPS if i < 0 else (i if i < rows else i - rows)
            for j in range(inner):
                free = lowest[j + 1] - heights[row, j]
                lowest[j + 1] = free
                dent = deepest if deepest < free else free
                v[j + 1] = zero if zero > dent else dent
        _wrap(v)
        _coarse_line(p, k, between, one, half, zero, line)
        _interpolate_row(line, ring[RING + slot], halve_y, half, zero)
        for s in range(1, SWEEPS + 1):
            if i - s >= s - SWEEPS:
                x = (start + i - s + n_x) % n_x
                inner = surface_points if x < surface_rows else 0
                _relax(ring, (s + 1) * RING, i - s, n, inner, couplings[s - 1])
        finished = i - SWEEPS
        if finished >= 0:
            slot = (finished + RING) % RING
            for j in range(n):
                g[finished, j] = ring[(SWEEPS + 2) * RING + slot, j + 1] - ring[slot, j + 1]


@inline
def _coarse_line(field, k, between, factor, near, far, line):
    """Set line[1:m + 1] to factor times coarse row k or, `between`, near (k + (k + 1)) + far ((k -
    1) + (k + 2)); k from this rank's first.
    """
    before = field[0].shape[0]
    owned_rows = field[1].shape[0]
    m = line.shape[0] - 3
    terms = 1
    if between:
        terms = 4 if far != 0 else 2
    for term in range(terms):
        row = k + term if term < 3 else k - 1
        rows = field[0] if row < 0 else (field[1] if row < owned_rows else field[2])
        row = row + before if row < 0 else (row if row < owned_rows else row - owned_rows)
        if term == 0:
            weight = near if between else factor
            for J in range(m):
                line[J + 1] = weight * rows[row, J]
        else:
            weight = near if term == 1 else far
            for J in range(m):
                line[J + 1] += weight * rows[row, J]


@inline
def _interpolate_row(line, fine, halve_y, near, far):
    """Set fine[1:-1] from line[1:-2], a copy or, with halve_y, interpolated by near and far; the
    ends of `line` are overwritten.
    """
    n = fine.shape[0] - 2
    m = line.shape[0] - 3
    if halve_y:
        line[0] = line[m]
        line[m + 1] = line[1]
        line[m + 2] = line[1 + 1 % m]
        for J in range(n // 2):
            fine[2 * J + 1] = line[J + 1]
            fine[2 * J + 2] = near * (line[J + 1] + line[J + 2]) + far * (line[J] + line[J + 3])
        if n % 2:
            fine[n] = line[m]
    else:
        for j in range(1, n + 1):
            fine[j] = line[j]


@inline
def _wrap(row):
    """Copy the last point of a periodic row before its first, and the first after its last."""
    n = row.shape[0] - 2
    row[0] = row[n]
    row[n + 1] = row[1]


@inline
def _relax(ring, at, i, n, inner, couplings):
    """Make one gradient step of v for row i, v >= -g_c on `inner` points but for dents; at: the
    input's ring, output follows; couplings: as a stencil, then c_s and the deepest dent.
    """
    with_itself, along_x, along_y, diagonal, c, deepest = couplings
    slot = (i + RING) % RING
    above = ring[at + (i - 1 + RING) % RING]
    v = ring[at + slot]
    below = ring[at + (i + 1 + RING) % RING]
    v_new = ring[at + RING + slot]
    lowest = ring[slot]
    p = ring[RING + slot]
    beside = ring[ring.shape[0] - 1]
    for j in range(n + 2):
        beside[j] = above[j] + below[j]
    for j in range(1, n + 1):
        v_new[j] = (
            with_itself * v[j]
            + along_x * beside[j]
            + along_y * (v[j - 1] + v[j + 1])
            + diagonal * (beside[j - 1] + beside[j + 1])
            - c * p[j]
        )
    for j in range(1, inner + 1):
        dent = v_new[j] + deepest
        dent = dent if dent < lowest[j] else lowest[j]
        v_new[j] = dent if dent > v_new[j] else v_new[j]
    _wrap(v_new)
