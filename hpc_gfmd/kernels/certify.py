"""Kernels of the certificate and of the cheap observables. Sums are in double precision whatever the fields are."""

import numpy as np

from .jit import kernel

BINS, PER_OCTAVE = 160, 4  # of squares: down to 2^-40 of the largest

# Where the surface ends within the grid, `inside` is the shape of this rank's part of it (the first rows and points of a slab); beyond
# it g is the displacement u itself, and nothing is closed. `contact_edges` and `undecided` get that part alone.


@kernel
def displacement_rows(g, h, x, i0, i1):
    """x = u = g - h in the precision of x, rows from 0; x = g beyond h."""
    for i in range(i0, i1):
        m = h.shape[1] if i < h.shape[0] else 0
        for j in range(m):
            x[i - i0, j] = x.dtype.type(g[i, j]) - x.dtype.type(h[i, j])
        for j in range(m, g.shape[1]):
            x[i - i0, j] = g[i, j]


@kernel
def judge(g, p, x, p0, inside, i0, i1):
    """p = p0 + x on rows i0..i1 (x = K u, rows from 0), and how it violates p >= 0, p g = 0.

    Returns sums: p^2 and p^4 off contact, p^2 in contact, p in contact, |p| g, points in contact, gap; and the largest -g and -p where
    g <= 0.
    """
    open_pp = open_p4 = closed_pp = closed_p = pg = gap = contact = 0.0
    worst = np.zeros((2, g.shape[1]))  # row after row: one maximum over all points would not use vectors
    for i in range(i0, i1):
        m = inside[1] if i < inside[0] else 0
        for j in range(m, g.shape[1]):
            q = p0 + x[i - i0, j]
            p[i, j] = q
            open_pp += q * q
            open_p4 += (q * q) * (q * q)
        for j in range(m):  # products and selections instead of branches: those keep the compiler from using vectors
            q = p0 + x[i - i0, j]
            d = 1.0 * g[i, j]
            p[i, j] = q
            closed = 1.0 if d <= 0 else 0.0
            t = closed if q > 0 else 0.0
            qt = t * q
            qo = q - qt
            open_pp += qo * qo
            open_p4 += (qo * qo) * (qo * qo)
            closed_pp += qt * qt
            closed_p += qt
            contact += t
            pg += abs(q) * d
            gap += d
            pull = closed * -q
            worst[0, j] = -d if -d > worst[0, j] else worst[0, j]
            worst[1, j] = pull if pull > worst[1, j] else worst[1, j]
    return open_pp, open_p4, closed_pp, closed_p, pg, contact, gap, worst[0].max(), worst[1].max()


@kernel
def open_moments(g, p):
    """Sums of p^2 and p^4 off contact."""
    squares = fourth = 0.0
    for i in range(g.shape[0]):
        for j in range(g.shape[1]):
            q = 0.0 if g[i, j] <= 0 and p[i, j] > 0 else 1.0 * p[i, j]
            squares += q * q
            fourth += (q * q) * (q * q)
    return squares, fourth


@kernel
def undecided(g, p, kap, tie, sure, largest, counts):
    """Count the points that errors of the pressure might move to the other side, by the square of what that takes.

    It takes |p| where g <= 0, g/kap elsewhere. counts (2, BINS), closed and open ones: bin k holds squares from
    largest 2^(-(k + 1)/PER_OCTAVE) on, the last one all smaller ones. Less than tie: on either side right, not counted; less than sure:
    takes nothing.
    """
    for i in range(g.shape[0]):
        for j in range(g.shape[1]):
            opened = g[i, j] > 0
            t = g[i, j] / kap if opened else abs(p[i, j])
            if t * t <= largest and t >= tie:
                k = BINS - 1
                if t > sure:
                    k = min(int(-PER_OCTAVE * np.log2(t * t / largest)), k)
                counts[1 if opened else 0, k] += 1


@kernel
def dual_rows(g, p, x, scale, inside, i0, i1):
    """x = e = p^ - p with the admissible pressure p^ = scale p in contact, 0 elsewhere; returns the sum of p^ g (0 if g >= 0)."""
    total = 0.0
    for i in range(i0, i1):
        m = inside[1] if i < inside[0] else 0
        for j in range(m, g.shape[1]):
            x[i - i0, j] = -x.dtype.type(p[i, j])
        for j in range(m):
            q = x.dtype.type(p[i, j])
            touching = g[i, j] <= 0 and q > 0
            a = scale * q if touching else 0.0
            x[i - i0, j] = a - q
            total += a * g[i, j]
    return total


@kernel
def contact_edges(g, p, below_g, below_p, around):
    """Segments between a contact point and a point out of contact, in this slab; below: the first row after the slab; around: whether
    the last point of a row is beside the first."""
    rows, n = g.shape
    count = 0
    for i in range(rows):
        for j in range(n):
            here = g[i, j] <= 0 and p[i, j] > 0
            right = j + 1 if j + 1 < n else (0 if around else j)
            count += here != (g[i, right] <= 0 and p[i, right] > 0)
            if i + 1 < rows:
                count += here != (g[i + 1, j] <= 0 and p[i + 1, j] > 0)
            else:
                count += here != (below_g[j] <= 0 and below_p[j] > 0)
    return count
