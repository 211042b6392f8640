"""The locally damped multilevel (BPX) preconditioner, distributed over slabs.

    M r = sum over levels of P ... P (weight_l + DAMPING theta_l)^-1 R ... R r

weight_l is the body's stiffness on that level (bodies/base.py), theta_l the local contact fraction: the restricted indicator of the
contact. Damping each level by it is what keeps the spectrum of M K on the free points narrow at every load, without a parameter to
tune.

The finest level is never swept here: the solver's own passes restrict to level 1 (p on F, the indicator of A, and x) and interpolate
from it. Levels whose rows are spread over the ranks exchange halo rows; once a level is small or thin it is summed onto every rank,
which then sweeps the rest alone.
"""

import numpy as np

from ..aligned import LINE, zeros_aligned
from ..kernels.bpx import UpdateSums, update_state
from ..kernels.multilevel import join_edges, restrict_level, smooth_level, sweep_whole
from ..parallel import halo
from .coarsening import Transfer, levels

DAMPING = 4.0  # of a level by the contact on it, over its stiffness
COUPLING = 1.05  # of what comes from the coarser levels
WHOLE_POINTS = 128 * 128  # levels of at most this many points are swept by every rank
THIN_ROWS = 2  # and so are levels of which some rank has fewer rows than this
# <r, S r> of a field of zero mean is at most so many times the compliance of the shortest wave times the sum over levels of
# <r, r>/weight. On all kinds of grids the largest eigenvalue is 2.21; of what solvers leave it is 0.5 to 1.6 times, mostly 1.2.
EQUIVALENCE = 1.8


class Multilevel:
    """The sweep for one grid and body in one precision. longest: rows per pass of the solver; whole_points: see WHOLE_POINTS."""

    def __init__(self, grid, body, dtype, longest, whole_points=None):
        self.grid, self.comm, self.dtype = grid, grid.comm, np.dtype(dtype)
        self.damping, self.coupling = self.dtype.type(DAMPING), self.dtype.type(COUPLING)
        hierarchy, weights, softness = levels(grid), body.weights(grid), body.softness(grid)
        if len(hierarchy) == 1:  # a single point: a coarse level that equals it, so that there is always one
            hierarchy, weights, softness = hierarchy * 2, [*weights] * 2, [*softness] * 2
        self.levels, self.weights, self.softness = hierarchy, np.asarray(weights, self.dtype), np.asarray(softness)

        self.transfers, self.spread = [], []
        starts = grid.starts
        for fine, coarse in zip(hierarchy, hierarchy[1:]):
            transfer = Transfer(fine.n, coarse.n, starts, self.comm.rank, self.dtype)
            self.transfers.append(transfer)
            starts = transfer.coarse_starts
            thin = np.diff(starts).min() < THIN_ROWS
            small = coarse.n[0] * coarse.n[1] <= (WHOLE_POINTS if whole_points is None else whole_points)
            if (thin and self.comm.size > 1) or small or coarse is hierarchy[-1]:
                break
            self.spread.append(coarse)
        # Level 1 is in the rank's own rows in any case: that is what the solver's passes write to and read from.
        self.fields = [np.zeros((3 if k == 0 else 2, t.rows + 2, t.m[1]), self.dtype) for k, t in enumerate(self.transfers)]
        self.whole = _Whole(hierarchy[len(self.spread) + 1:], self.weights[len(self.spread) + 1:], self.softness[len(self.spread) + 1:])

        first = self.transfers[0]
        self.passes = first.passes(longest)
        self.lo = np.array([first.k0[a] for a, _ in self.passes], np.int64)
        self.hi = np.array([first.k0[b - 1] + 1 for _, b in self.passes], np.int64)
        # One thread joins every pass as soon as it is done; with several they all have to be kept.
        self.in_order = grid.threads == 1
        self.edges = np.zeros((1 if self.in_order else len(self.passes), 2, 3, first.m[1]), self.dtype)

    @property
    def nbytes(self):
        """Bytes held on this rank."""
        return sum(a.nbytes for a in self.fields) + self.edges.nbytes + self.whole.nbytes

    def update_rows(self, k, g, p, d, x, s, scratch, excess=0.0):
        """Pass k of the solver's update of its state, see kernels/bpx.py; returns its UpdateSums as a plain tuple."""
        edges = self.edges[0 if self.in_order else k]
        sums = update_state(g, p, d, x, s, self.dtype.type(excess), self.passes[k], self.fields[0], edges, self.transfers[0].tables,
                            self.grid.inside, scratch)
        if self.in_order:
            self._join(k)
        return sums

    def _join(self, k):
        """Add what pass k left over for rows that it shares with its neighbours."""
        if k == 0:
            self.fields[0][:, 0] = 0
            self.fields[0][:, -1] = 0
        shared = k > 0 and self.hi[k - 1] == self.lo[k]
        join_edges(self.fields[0], self.edges[0 if self.in_order else k], self.lo[k], self.hi[k], shared)

    @property
    def z(self):
        """The result on level 1, own rows and halo, (rows + 2, m)."""
        return self.fields[0][0]

    def sweep(self):
        """From what the update passes restricted to level 1, make z on level 1 (own rows and halo).

        Returns this rank's share of <p, M' p> and <x, M' p>, both on F, as sums over level 1 times N/N_1: M' is M without the
        finest level; and of the sums over these levels of softness times <r, r>, <t, t> and <r, t>, r and t being p on F and the
        indicator of A restricted to the level, times N/N_l.
        """
        if not self.passes:
            self.fields[0][...] = 0
        elif not self.in_order:
            for k in range(len(self.passes)):
                self._join(k)
        return self.sweep_levels()

    def sweep_levels(self):
        """`sweep` of what fields[0] holds, its halo rows still to be added to the neighbours' rows."""
        first = self.transfers[0]
        for k in range(len(self.spread)):
            halo.accumulate(self.comm, self.fields[k])
            restrict_level(self.fields[k][:2], self.fields[k + 1], self.transfers[k + 1].tables)
        rz, xz, *squares = self._sweep_whole()
        for k in reversed(range(len(self.spread))):
            rz, xz, *here = self._smooth(k)
            share = self.softness[k + 1] * self.grid.cell_points / (self.levels[k + 1].n[0] * self.levels[k + 1].n[1])
            squares = [a + b * share for a, b in zip(squares, here)]
            halo.fill(self.comm, self.fields[k][0])
        ratio = self.grid.cell_points / (first.m[0] * first.m[1])
        return rz * ratio, xz * ratio, *squares

    def without_mean(self, squares, mean2):
        """sum over levels of softness <r, t> for r and t less their means; squares: that of r and t themselves, of all levels and
        ranks; mean2: product of the means."""
        return float(squares - self.grid.cell_points * mean2 * np.sum(self.softness))

    def restrict(self, g, p, excess):
        """From a state that no step has led to, what the update passes restrict; returns UpdateSums. excess: see kernels/bpx.py."""
        longest = max((i1 - i0 for i0, i1 in self.passes), default=0)
        still = np.zeros((longest, self.grid.n[1]), self.dtype)
        scratch = zeros_aligned((7, self.grid.n[1] + LINE // self.dtype.itemsize), self.dtype)
        sums = [self.update_rows(k, g, p, g, still, self.dtype.type(0), scratch, excess) for k in range(len(self.passes))]
        return UpdateSums.total(sums)

    def _sweep_whole(self):
        """Sum the last level that is spread onto every rank, sweep the rest, take back this rank's rows."""
        t = self.transfers[-1]
        a = self.fields[-1]
        whole = halo.sum_to_all(self.comm, a, t.start, t.m[0])
        z, squares, self.mean = self.whole.sweep(whole[0], whole[1])
        halo.take_rows(z, t.start, a[0])
        if self.comm.rank:  # rank 0 alone contributes what all have
            return 0.0, 0.0, 0.0, 0.0, 0.0
        ratio = self.grid.cell_points / (t.m[0] * t.m[1])
        products = (0.0, 0.0) if self.spread else (_dot(whole[0], z), _dot(whole[2], z))  # where level 1 itself is whole
        return *products, *(a * ratio for a in squares)

    def _smooth(self, k):
        a, z = self.fields[k], self.fields[k + 1][0]
        return smooth_level(a, z, a[0], self.weights[k + 1], self.damping, self.coupling, self.transfers[k + 1].tables)


def _dot(a, b):
    """Not by BLAS, whose threads would get into the way of the other ranks."""
    return float(np.einsum("ij,ij->", a, b))


class _Whole:
    """The coarse levels that every rank sweeps alone, in one call."""

    def __init__(self, levels, weights, softness):
        dtype = weights.dtype
        self.shapes = np.array([level.n for level in levels], np.int64).reshape(-1, 2)
        sizes = self.shapes[:, 0] * self.shapes[:, 1]
        self.offsets = np.concatenate([[0], np.cumsum(sizes)[:-1]]).astype(np.int64)
        self.weights, self.softness = weights, softness
        self.r, self.t = np.zeros(sizes.sum(), dtype), np.zeros(sizes.sum(), dtype)
        self.c, self.w = dtype.type(DAMPING), dtype.type(COUPLING)

    @property
    def nbytes(self):
        return self.r.nbytes + self.t.nbytes

    def sweep(self, r, t):
        n = r.size
        self.r[:n] = r.ravel()
        self.t[:n] = t.ravel()
        *squares, mean = sweep_whole(self.r, self.t, self.shapes, self.offsets, self.weights, self.softness, self.c, self.w)
        return self.r[:n].reshape(r.shape), squares, mean
