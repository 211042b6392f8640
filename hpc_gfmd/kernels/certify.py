"""Kernels of the certificate and of the cheap observables. Sums are in double precision whatever
the fields are."""

from typing import NamedTuple

import numpy as np

from .jit import kernel, making_arrays, points_inside
from .yielding import limit, yields

BINS, PER_OCTAVE = 160, 4  # of squares: down to 2^-40 of the largest
# points that are looked at together; more than rounding in single precision makes of a number
GROUP, ROUNDED = 32, 1.00001

# Fields are local slabs (n_loc, n_y), x scratch (>= i1 - i0, n_y) that begins with row i0, h its
# part of the nominal area. Where the surface ends within the grid, `inside` is the shape of this
# rank's part of it (the first rows and points of a slab); beyond it g is the displacement u itself,
# and nothing is closed. Not a part of an array: its rows would not use vectors.


class KktSums(NamedTuple):
    """Sums over points: p, p^2 and p^4 out of contact (less the hardness where a point yields), p^2
    in contact, |p| g, points in contact, gap; points of the contact that yield."""

    open_p: float
    open_pp: float
    open_p4: float
    closed_pp: float
    pg: float
    contact: float
    gap: float
    yielded: float


class KktExtremes(NamedTuple):
    """The largest -g that is no dent, and the largest -p where g <= 0."""

    penetration: float
    tension: float


@kernel
def displacement_rows(g, h, x, i0, i1, level):
    """Set x = u - level, u = g - h, in the precision of x, rows from 0; u = g beyond h."""
    for i in range(i0, i1):
        m = points_inside(i, h.shape)
        for j in range(m):
            x[i - i0, j] = 1.0 * g[i, j] - 1.0 * h[i, j] - level
        for j in range(m, np.uint64(g.shape[1])):
            x[i - i0, j] = 1.0 * g[i, j] - level


@making_arrays
def kkt_residuals(g, p, x, p0, hardness, inside, i0, i1):
    """Set p = p0 + x on rows i0..i1 (x = K u, rows from 0); returns how it violates p >= 0, p g =
    0: KktSums and KktExtremes."""
    open_p = open_pp = open_p4 = closed_pp = pg = gap = contact = yielded = 0.0
    most = limit(hardness, 0.0)
    # row after row: one maximum over all points would not use vectors
    worst = np.zeros((2, g.shape[1]))
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
            y = yields(gij, p_new, hardness, 0.0, 1.0)
            t = closed if p_new > 0 and y == 0 else 0.0
            p_closed = t * p_new + y * most
            dent = gij if y > 0 else 0.0
            p_open = p_new - p_closed
            open_p += p_open
            open_pp += p_open * p_open
            open_p4 += (p_open * p_open) * (p_open * p_open)
            closed_pp += p_closed * p_closed
            contact += t + y
            pg += abs(p_new - y * most) * (gij - 2 * dent)
            gap += gij - dent
            yielded += y
            tension = closed * -p_new
            worst[0, j] = dent - gij if dent - gij > worst[0, j] else worst[0, j]
            worst[1, j] = tension if tension > worst[1, j] else worst[1, j]
    sums = KktSums(open_p, open_pp, open_p4, closed_pp, pg, contact, gap, yielded)
    penetration = tension = 0.0
    for j in range(g.shape[1]):
        penetration = worst[0, j] if worst[0, j] > penetration else penetration
        tension = worst[1, j] if worst[1, j] > tension else tension
    return sums, KktExtremes(penetration, tension)


@kernel
def open_moments(g, p, hardness, inside):
    """Return the sums of p^2 and p^4 off contact, less the hardness where a point yields."""
    squares = fourth = 0.0
    most = limit(hardness, 0.0)
    for i in range(inside[0]):
        for j in range(inside[1]):
            y = yields(g[i, j], p[i, j], hardness, 0.0, 1.0)
            p_open = 0.0 if g[i, j] <= 0 and p[i, j] > 0 and y == 0 else 1.0 * p[i, j] - y * most
            squares += p_open * p_open
            fourth += (p_open * p_open) * (p_open * p_open)
    return squares, fourth


@kernel
def count_uncertain(g, p, inside, compliance, tie, sure, largest, fall, counts):
    """Count the points that errors of the pressure might move into contact or out of it, by the
    square of what that takes.

    It takes |p| where g <= 0, elsewhere g/compliance less the pressure that is left there, which
    closes the point by itself. Where the body as a whole may be wrong by the height `fall` that
    takes as much less. counts (2, BINS), points in contact and out of it: bin k holds
    squares from largest 2^(-(k + 1)/PER_OCTAVE) on, the last one all smaller ones. Less than tie:
    on either side right, not counted; less than sure: takes nothing.
    """
    real = g.dtype.type
    given = fall / compliance
    reach, stiffness, zero = real(ROUNDED * np.sqrt(largest) + given), real(1 / compliance), real(0)
    rows, n = inside
    for i in range(rows):
        for j0 in range(0, n, GROUP):
            here, pressure = g[i, j0 : min(j0 + GROUP, n)], p[i, j0 : min(j0 + GROUP, n)]
            near = 0
            for j in range(here.shape[0]):  # with vectors: few groups have any
                near += (
                    stiffness * here[j] - max(pressure[j], zero)
                    if here[j] > 0
                    else abs(pressure[j])
                ) <= reach
            if near == 0:
                continue
            for j in range(here.shape[0]):
                t = here[j] / compliance if here[j] > 0 else abs(pressure[j])
                if t < tie:
                    continue
                if here[j] > 0:
                    t = t - max(pressure[j], zero)
                t = max(t - given, 0.0)
                if t * t <= largest:
                    k = BINS - 1
                    if t > sure:
                        k = min(int(-PER_OCTAVE * np.log2(t * t / largest)), k)
                    counts[0 if here[j] <= 0 and pressure[j] > 0 else 1, k] += 1


@kernel
def count_heights(g, inside, largest, counts):
    """Count open points by their gap, and dents by their depth.

    Parameters
    ----------
    g : array, rows of a local slab
        Gap.
    inside : tuple of int
        Rows and points of each row that belong to the surface.
    largest : float
        Upper end of the first bin.
    counts : array (2, BINS + 1)
        Open points and dents; bin k gets heights from largest 2^(-k/PER_OCTAVE) down to the next
        one, bin BINS - 1 all smaller ones. The last column gets the points with g <= 0, and with
        g < 0.
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
def dual_rows(g, p, x, scale, shift, hardness, inside, i0, i1):
    """Set x = e = p^ - p with the admissible pressure p^ = scale p + shift in contact, the hardness
    where a point yields, 0 elsewhere; returns the sum of p^ g (0 if g >= 0) out of dents."""
    total = 0.0
    zero, one = x.dtype.type(0), x.dtype.type(1)
    most = limit(hardness, zero)
    for i in range(i0, i1):
        m = points_inside(i, inside)
        for j in range(m, np.uint64(g.shape[1])):
            x[i - i0, j] = -x.dtype.type(p[i, j])
        for j in range(m):
            pij = x.dtype.type(p[i, j])
            y = yields(g[i, j], pij, hardness, zero, one)
            touching = g[i, j] <= 0 and pij > 0 and y == zero
            admissible = scale * pij + shift if touching else 0.0
            x[i - i0, j] = admissible - pij + y * most
            total += admissible * g[i, j]
    return total
