"""Slab-decomposed two-dimensional real FFT in passes that work on cache-sized pieces.

Every rank owns a slab of rows of the real field. A transform is never done on a whole field: the caller hands in functions that
make or use a few rows at a time (they stay in cache between the caller's arithmetic and the row transform), and functions that
work on a few complete columns of the spectrum (likewise). One field of complex numbers is all the memory a convolution needs:

    forward_rows(fill)    fill(i0, i1, x) makes rows i0..i1 of the real field -> row spectra
    columns(apply)        all-to-all of a block of columns, turn, transform, apply(block, m), transform back, turn back, all-to-all
    backward_rows(use)    use(i0, i1, x) gets rows i0..i1 of the convolved field

The row spectra are stored as M blocks of W columns, shape (M, n_loc, W); block m = k P + r belongs to rank r, so the send
buffers of the all-to-all number k are contiguous as they stand. The last blocks may hold padding columns (weight 0). To be
transformed a block is turned: contiguous columns (W, n_x) are transformed up to twice as fast.

Convention: h_q = (1/N) sum_r h(r) exp(-i q r), h(r) = sum_q h_q exp(i q r). The transforms here leave out 1/N in both directions;
`scale` = 1/N is folded into the kernels that work on columns.
"""

from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ..aligned import empty_aligned
from ..kernels.spectral import from_blocks, to_blocks, turn, turn_back
from .plans import Plans
from .wisdom import planned

COLUMN_BYTES = 256 * 1024  # of a block of columns, which is turned in the second-level cache
ROW_BYTES = 256 * 1024  # of the spectra of one pass of rows: these share the second-level cache with the rows of the caller's fields
MIN_WIDTH, MAX_WIDTH = 8, 64


def row_starts(n_x, size):
    """First row of every rank, and n_x: the block distribution of mpi4py-fft."""
    return np.array([r * (n_x // size) + min(r, n_x % size) for r in range(size + 1)])


def scratch_bytes(n_loc, n, itemsize, size):
    """About how many bytes each thread has for itself in a SlabFFT with n_loc rows; itemsize: of a complex number."""
    n_c = n[1] // 2 + 1
    rows = min(max(ROW_BYTES, 8 * n_c * itemsize), n_loc * n_c * itemsize)
    columns = min(max(COLUMN_BYTES, MIN_WIDTH * n[0] * itemsize), n[0] * n_c * itemsize)
    return 2 * rows + columns * (2 if size > 1 else 1)


class SlabFFT:
    """Transforms of one grid in one precision.

    n: (n_x, n_y) global; starts: first row of each rank plus n_x; dtype: of the real field; threads: of this rank.
    """

    def __init__(self, comm, n, starts, dtype, threads=1):
        self.comm, self.n = comm, n
        self.dtype = np.dtype(dtype)
        self.starts = np.asarray(starts)
        self.n_loc = int(self.starts[comm.rank + 1] - self.starts[comm.rank])
        n_x, n_y = n
        self.n_c = n_y // 2 + 1
        self.scale = 1.0 / (n_x * n_y)
        complex_dtype = np.result_type(self.dtype, np.complex64)
        self.W, self.K = self._block_width(complex_dtype.itemsize)
        self.M = self.K * comm.size

        self.R = self._rows_per_pass(complex_dtype.itemsize)
        self.threads = threads
        self._pool = ThreadPoolExecutor(threads) if threads > 1 else None
        self.blocks = empty_aligned((self.M, self.n_loc, self.W), complex_dtype)
        self.blocks[...] = 0.0  # also touches the pages, and keeps padding columns free of NaN
        self._scratch = []
        for _ in range(threads):
            real = empty_aligned((self.R, n_y), self.dtype)
            half = empty_aligned((self.R, self.n_c), complex_dtype)
            turned = empty_aligned((self.W, n_x), complex_dtype)
            block = empty_aligned((n_x, self.W) if comm.size > 1 else (0, self.W), complex_dtype)  # what other ranks send
            real[...], half[...], turned[...], block[...] = 0, 0, 0, 0
            self._scratch.append((real, half, turned, block))
        self.plans = planned(comm, self.dtype, lambda: Plans(*self._scratch[0][:3]))
        for a in self._scratch[0][:3]:
            a[...] = 0  # planning has left noise

    def _block_width(self, itemsize):
        """W and K so that a block of complete columns fits the cache and little is padded."""
        n_x, per_rank = self.n[0], -(-self.n_c // self.comm.size)
        wanted = int(np.clip(COLUMN_BYTES // (n_x * itemsize), MIN_WIDTH, MAX_WIDTH))
        K = -(-per_rank // wanted)
        W = -(-per_rank // K)
        if K > 1:
            W = -(-W // (64 // itemsize)) * (64 // itemsize)  # every block starts on a cache line, as the plans expect
            K = -(-per_rank // W)
        return W, K

    def _rows_per_pass(self, itemsize):
        wanted = int(np.clip(ROW_BYTES // (self.n_c * itemsize), 8, 256))
        longest = int(np.diff(self.starts).max())  # on any rank: all plan alike
        passes = max(1, -(-longest // wanted))
        R = max(1, -(-longest // passes))
        return R + R % 2 if R > 1 else R  # even: a coarse row then belongs to one pass

    @property
    def nbytes(self):
        """Bytes that this object holds on this rank."""
        return self.blocks.nbytes + sum(a.nbytes for s in self._scratch for a in s)

    @property
    def row_scratch(self):
        """The arrays x that row functions are called with: one for each thread."""
        return [scratch[0] for scratch in self._scratch]

    def passes(self):
        """The row ranges [(i0, i1), ...], local, that one pass handles at a time."""
        return [(i, min(i + self.R, self.n_loc)) for i in range(0, self.n_loc, self.R)]

    def columns_of(self, m):
        """The columns [j0, j1) of the half spectrum that block m holds; the rest of its W columns is padding."""
        j0 = min(m * self.W, self.n_c)
        return j0, min(j0 + self.W, self.n_c)

    def forward_rows(self, fill, passes=None):
        """Transform rows made by fill(i0, i1, x), x: (R, n_y) scratch; returns what fill returned, in the order of the passes."""

        def one(i0, i1, scratch):
            real, half = scratch[:2]
            result = fill(i0, i1, real)
            self.plans.rows_forward(real, half)
            to_blocks(half, self.blocks, i0, i1 - i0)
            return result

        return self._map(one, passes or self.passes())

    def backward_rows(self, use, passes=None):
        """Hand the rows of the real field to use(i0, i1, x), x: (R, n_y) scratch; returns what use returned, in order."""

        def one(i0, i1, scratch):
            real, half = scratch[:2]
            from_blocks(self.blocks, half, i0, i1 - i0)
            self.plans.rows_backward(half, real)
            return use(i0, i1, real)

        return self._map(one, passes or self.passes())

    def columns(self, apply, forward=True, backward=True):
        """Call apply(block, m) on every block of complete columns of this rank, block: (W, n_x); returns the results in order.

        forward/backward=False leaves out the transform along axis 0 (and the all-to-all) on that side; a block that was not
        transformed forward is all zero.
        """
        if self.comm.size == 1:
            return self._map(lambda m, _, scratch: self._one_block(self.blocks[m], scratch[2], m, apply, forward, backward),
                             [(m, m) for m in range(self.M)])
        return self._columns_mpi(apply, forward, backward)

    def _one_block(self, block, turned, m, apply, forward, backward):
        """block: (n_x, W) complete columns as they are stored."""
        if forward:
            turn(_moved(block), _moved(turned))
            self.plans.columns_forward(turned, turned)
        else:
            turned[...] = 0
        result = apply(turned, m)
        if backward:
            self.plans.columns_backward(turned, turned)
            turn_back(_moved(turned), _moved(block))
        return result

    def _columns_mpi(self, apply, forward, backward):
        size, rank, W = self.comm.size, self.comm.rank, self.W
        itemsize = self.blocks.itemsize
        rows = np.diff(self.starts)
        here = [np.full(size, self.n_loc * W * itemsize), np.arange(size) * (self.n_loc * W * itemsize)]
        there = [rows * (W * itemsize), self.starts[:-1] * (W * itemsize)]
        mpi = self.comm.mpi
        results = []
        for k0 in range(0, self.K, self.threads):
            group = range(k0, min(k0 + self.threads, self.K))
            for k, scratch in zip(group, self._scratch):
                if forward:
                    slab = self.blocks[k * size:(k + 1) * size]
                    mpi.Alltoallv([slab.view(np.uint8), *here, _BYTE()], [scratch[3].view(np.uint8), *there, _BYTE()])

            def one(k, first, _):
                _, _, turned, block = self._scratch[k - first]
                return self._one_block(block, turned, k * size + rank, apply, forward, backward)

            results += self._map(one, [(k, k0) for k in group])
            for k, scratch in zip(group, self._scratch):
                if backward:
                    slab = self.blocks[k * size:(k + 1) * size]
                    mpi.Alltoallv([scratch[3].view(np.uint8), *there, _BYTE()], [slab.view(np.uint8), *here, _BYTE()])
        return results

    def _map(self, one, ranges):
        """one(a, b, scratch) for all ranges, on all threads; results in the order of the ranges whatever the thread count."""
        if self._pool is None or len(ranges) == 1:
            return [one(a, b, self._scratch[0]) for a, b in ranges]
        share = -(-len(ranges) // self.threads)

        def work(t):
            return [one(a, b, self._scratch[t]) for a, b in ranges[t * share:(t + 1) * share]]

        return [r for part in self._pool.map(work, range(self.threads)) for r in part]


def _moved(a):
    """The same memory in a type that the compiler moves at once."""
    return a.view(np.float64) if a.dtype == np.complex64 else a


def _BYTE():
    from mpi4py import MPI

    return MPI.BYTE
