"""Kernels of the certificate and of its errors: the sums of (7) to (11) in docs/method.md, in
double precision whatever the fields are.

Letters, of fields: local slabs (n_loc, n_y), in the units of operators/problem.py.

=============  ===================================================================================
g              gap; g < 0 is the depth of a dent (only with a hardness)
p              pressure
h              initial gap, of the surface alone
x              scratch (>= i1 - i0, n_y) whose row 0 is row i0 of the slab
H              hardness, None without one (numba then drops all that depends on it)
at_limit       pressure of a point that yields: H, or 0 without a hardness
plastic        1 where a point yields, else 0 (yielding.py)
inside         shape (rows, points) of this rank's part of the surface: its first rows and points
i0, i1         the rows i0 <= i < i1 of the slab
=============  ===================================================================================

Where the surface ends within the grid, g is the displacement u itself beyond it, and nothing is
closed. `inside` is not a part of an array, whose rows would not use vectors.
"""

from typing import NamedTuple

import numpy as np

from .atomic import add
from .jit import inline, kernel, points_inside
from .transforms import store_rows
from .yielding import limit, yields

BINS = 160  # of the histograms: down to 2^-40 of the largest
PER_OCTAVE = 4  # bins
GROUP = 32  # points that are looked at together
ROUNDED = 1.00001  # more than rounding in single precision makes of a number


class KktSums(NamedTuple):
    """Sums over points: p, p^2, p^4 out of contact (yielding: p - H), p^2 in contact, |p| g
    (yielding: |p - H| times depth); points in contact, g without dents, yielding points.
    """

    open_p: float
    open_pp: float
    open_p4: float
    closed_pp: float
    pg: float
    contact: float
    gap: float
    yielded: float


@kernel
def displacement_passes(passes, shares, turns, rows, g, h, level):
    """Transform rows of u - level (`displacement_rows`), threads as in bpx.py: search_passes."""
    share = add(turns, 0, 1)
    while share < shares.shape[0]:
        for k in range(shares[share, 0], shares[share, 1]):
            i0 = passes[k, 0]
            i1 = passes[k, 1]
            displacement_rows(g, h, rows[0], i0, i1, level)
            store_rows(rows[1], i0, i1)
        share = add(turns, 0, 1)


@inline
def displacement_rows(g, h, x, i0, i1, level):
    """Set x = u - level on rows i0 <= i < i1, u = g - h on the surface and u = g beyond it."""
    for i in range(i0, i1):
        m = points_inside(i, h.shape)
        for j in range(m):
            x[i - i0, j] = 1.0 * g[i, j] - 1.0 * h[i, j] - level
        for j in range(m, np.uint64(g.shape[1])):
            x[i - i0, j] = 1.0 * g[i, j] - level


@kernel
def kkt_residuals(g, p, x, p0, H, inside, i0, i1, worst):
    """Set p = p0 + x, x being K u; return KktSums and the largest -p where g <= 0. `worst` (n_y,),
    0 at first: by column, as one maximum would not use vectors.
    """
    open_p = open_pp = open_p4 = closed_pp = pg = gap = contact = yielded = 0.0
    at_limit = limit(H, 0.0)
    for i in range(i0, i1):
        m = points_inside(i, inside)
        for j in range(m, np.uint64(g.shape[1])):
            p_new = p0 + x[i - i0, j]
            p[i, j] = p_new
            open_p += p_new
            open_pp += p_new * p_new
            open_p4 += (p_new * p_new) * (p_new * p_new)
        # products and selections instead of branches: those keep the compiler from using vectors
        for j in range(m):
            p_new = p0 + x[i - i0, j]
            gij = 1.0 * g[i, j]
            p[i, j] = p_new
            closed = 1.0 if gij <= 0 else 0.0
            plastic = yields(gij, p_new, H, 0.0, 1.0)
            t = closed if p_new > 0 and plastic == 0 else 0.0
            p_closed = t * p_new + plastic * at_limit
            dent = gij if plastic > 0 else 0.0
            p_open = p_new - p_closed
            open_p += p_open
            open_pp += p_open * p_open
            open_p4 += (p_open * p_open) * (p_open * p_open)
            closed_pp += p_closed * p_closed
            contact += t + plastic
            pg += abs(p_new - plastic * at_limit) * (gij - 2 * dent)
            gap += gij - dent
            yielded += plastic
            tension = closed * -p_new
            worst[j] = tension if tension > worst[j] else worst[j]
    sums = KktSums(open_p, open_pp, open_p4, closed_pp, pg, contact, gap, yielded)
    tension = 0.0
    for j in range(g.shape[1]):
        tension = worst[j] if worst[j] > tension else tension
    return sums, tension


@kernel
def open_moments(g, p, H, inside):
    """Return sums of p^2 and p^4 out of contact, of p - H where a point yields."""
    squares = fourth = 0.0
    at_limit = limit(H, 0.0)
    for i in range(inside[0]):
        for j in range(inside[1]):
            plastic = yields(g[i, j], p[i, j], H, 0.0, 1.0)
            p_open = 1.0 * p[i, j] - plastic * at_limit
            if g[i, j] <= 0 and p[i, j] > 0 and plastic == 0:
                p_open = 0.0
            squares += p_open * p_open
            fourth += (p_open * p_open) * (p_open * p_open)
    return squares, fourth


@kernel
def count_uncertain(g, p, inside, compliance, tie, sure, largest, fall, counts):
    """Count points by the square of the pressure error that moves them into contact or out of it.

    That error is |p| where g <= 0, elsewhere g/compliance less the pressure left there, less
    fall/compliance where the body may be too high or low. Below `tie`, before deductions, a point
    is right on either side; below `sure` it is in the last bin. counts (2, BINS): in and out of
    contact; bin k from largest 2^(-(k + 1)/PER_OCTAVE) on.
    """
    real = g.dtype.type
    by_fall = fall / compliance
    reach = real(ROUNDED * np.sqrt(largest) + by_fall)
    stiffness = real(1 / compliance)
    zero = real(0)
    rows, points = inside
    for i in range(rows):
        for j0 in range(0, points, GROUP):
            gaps = g[i, j0 : min(j0 + GROUP, points)]
            pressures = p[i, j0 : min(j0 + GROUP, points)]
            near = 0
            for j in range(gaps.shape[0]):  # with vectors: few groups have any
                near += (
                    stiffness * gaps[j] - max(pressures[j], zero)
                    if gaps[j] > 0
                    else abs(pressures[j])
                ) <= reach
            if near == 0:
                continue
            for j in range(gaps.shape[0]):
                takes = gaps[j] / compliance if gaps[j] > 0 else abs(pressures[j])
                if takes < tie:
                    continue
                if gaps[j] > 0:
                    takes = takes - max(pressures[j], zero)
                takes = max(takes - by_fall, 0.0)
                if takes * takes <= largest:
                    k = BINS - 1
                    if takes > sure:
                        k = min(int(-PER_OCTAVE * np.log2(takes * takes / largest)), k)
                    counts[0 if gaps[j] <= 0 and pressures[j] > 0 else 1, k] += 1


@kernel
def changing_points(points, takes, mean_square, by_load, squares, reach, few, all_change):
    """Return how many points of a histogram change sides, with a margin for scatter.

    In reach are points whose change takes less than `reach` times the rms error of the pressure
    (`mean_square`): with `all_change` all of them are expected to change, otherwise those of the
    half of this range with more points, and at least `by_load`. The root of the expected number is
    added. No less than `few`, or than all points if these are fewer, and no more than a sum of
    squared changes of `squares` moves, the easiest first.

    points, takes: (BINS,), number of points and squared change of pressure of each bin.
    """
    near = 0.0
    within = 0.0
    total = 0.0
    spent = 0.0
    affordable = 0.0
    fits = True
    for k in range(BINS - 1, -1, -1):  # the easiest first
        number = points[k]
        if number == 0:
            continue
        total += number
        if takes[k] < mean_square * reach**2:
            within += number
            if takes[k] < mean_square * (reach / 2) ** 2:
                near += number
        work = number * takes[k]
        if spent + work <= squares:
            affordable += fits * number
            spent += work
        elif fits:
            affordable += (squares - spent) / takes[k]
            fits = False
    expected = within if all_change else max(near, within - near)
    expected = max(expected, by_load)
    likely = max(expected + np.sqrt(expected), min(total, few), 0.0)
    return min(likely, np.floor(affordable))


@kernel
def count_heights(g, inside, largest, counts):
    """Count open points by gap, dents by depth: counts (2, BINS + 1), bin k from largest
    2^(-k/PER_OCTAVE) down, larger ones not; last column: g <= 0, g < 0.
    """
    for i in range(inside[0]):
        for j in range(inside[1]):
            height = 1.0 * g[i, j]
            side = 0
            if height <= 0:
                counts[0, BINS] += 1
                if height == 0:
                    continue
                counts[1, BINS] += 1
                side = 1
                height = -height
            if height <= largest:
                k = min(int(-PER_OCTAVE * np.log2(height / largest)), BINS - 1)
                counts[side, k] += 1


@kernel
def dual_rows(g, p, x, scale, shift, H, inside, i0, i1):
    """Set x = p^ - p: p^ = scale p + shift in elastic contact, H where it yields, else 0."""
    zero = x.dtype.type(0)
    unit = x.dtype.type(1)
    at_limit = limit(H, zero)
    for i in range(i0, i1):
        m = points_inside(i, inside)
        for j in range(m, np.uint64(g.shape[1])):
            x[i - i0, j] = -x.dtype.type(p[i, j])
        for j in range(m):
            pij = x.dtype.type(p[i, j])
            plastic = yields(g[i, j], pij, H, zero, unit)
            touching = g[i, j] <= 0 and pij > 0 and plastic == zero
            admissible = scale * pij + shift if touching else 0.0
            x[i - i0, j] = admissible - pij + plastic * at_limit
