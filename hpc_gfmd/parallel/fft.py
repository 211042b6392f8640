"""Slab-decomposed two-dimensional real FFT in passes that work on cache-sized pieces.

Every rank owns a slab of rows of the real field. A transform is never done on a whole field: the caller hands in functions that
make or use a few rows at a time (they stay in cache between the caller's arithmetic and the row transform), and functions that
work on a few complete columns of the spectrum (likewise). One field of complex numbers is all the memory a convolution needs:

    forward_rows(fill)    fill(i0, i1, x) makes rows i0..i1 of the real field -> row spectra
    columns(apply)        all-to-all of a block of columns, transpose, transform, apply(block, m), and all of it back
    backward_rows(use)    use(i0, i1, x) gets rows i0..i1 of the convolved field

The columns are cut into M blocks of nearly the same width; block m = k P + r belongs to rank r. The row spectra are stored block by
block, so the send buffers of the all-to-all number k are contiguous as they stand, and nothing is padded. To be transformed a block is
transposed: contiguous columns (width, n_x) are transformed up to twice as fast.

Convention: h_q = (1/N) sum_r h(r) exp(-i q r), h(r) = sum_q h_q exp(i q r). The transforms here leave out 1/N in both directions;
`scale` = 1/N is folded into the kernels that work on columns.
"""

from concurrent.futures import ThreadPoolExecutor
from functools import cached_property

import numpy as np

from ..aligned import zeros_aligned
from ..kernels.spectral import from_blocks, to_blocks, transpose, transpose_back
from .plans import Plans
from .wisdom import planned

COLUMN_BYTES = 256 * 1024  # of a block of columns, which is transposed in the second-level cache
ROW_BYTES = 256 * 1024  # of the spectra of one pass of rows: these share the second-level cache with the rows of the caller's fields
MIN_WIDTH, MAX_WIDTH = 8, 64


def row_starts(n_x, size):
    """First row of every rank, and n_x: the block distribution of mpi4py-fft."""
    return np.array([r * (n_x // size) + min(r, n_x % size) for r in range(size + 1)])


class Layout:
    """Who has which rows of a field and which columns of its half spectrum, and what is sent: no memory, no message.

    n: (n_x, n_y) global; starts: first row of each rank plus n_x; itemsize: of a complex number. edges: first column of every block,
    and their number n_c; K: blocks of each rank; W: columns of the widest block; R: rows that are transformed at a time.
    """

    def __init__(self, n, starts, rank, itemsize):
        self.n, self.starts, self.rank, self.itemsize = n, np.asarray(starts), rank, itemsize
        self.size = len(self.starts) - 1
        self.n_c = n[1] // 2 + 1
        self.n_loc = int(self.starts[rank + 1] - self.starts[rank])
        self.edges = self._edges()
        self.M = len(self.edges) - 1
        self.K = self.M // self.size
        self.W = int(np.diff(self.edges).max())
        self.R = self._rows_per_pass()

    def _edges(self):
        """Blocks of complete columns that fit the cache. On several ranks all have the same number of them, and as many columns but for
        one; one rank needs no such balance, and has blocks that begin on cache lines."""
        wanted = int(np.clip(COLUMN_BYTES // (self.n[0] * self.itemsize), MIN_WIDTH, MAX_WIDTH))
        if self.size > 1:
            K = max(1, round(self.n_c / self.size / wanted))
            return row_starts(self.n_c, K * self.size)
        K = -(-self.n_c // wanted)
        W = -(-self.n_c // K)
        if K > 1:
            W = -(-W // (64 // self.itemsize)) * (64 // self.itemsize)
        return np.append(np.arange(0, self.n_c, W), self.n_c)

    def _rows_per_pass(self):
        wanted = int(np.clip(ROW_BYTES // (self.n_c * self.itemsize), 8, 256))
        longest = int(np.diff(self.starts).max())  # on any rank: all plan alike
        passes = max(1, -(-longest // wanted))
        R = max(1, -(-longest // passes))
        return R + R % 2 if R > 1 else R  # even: a coarse row then belongs to one pass

    def columns_of(self, m):
        """The columns [j0, j1) of the half spectrum that block m holds."""
        return int(self.edges[m]), int(self.edges[m + 1])

    @property
    def columns_held(self):
        """Number of columns of every rank."""
        return np.diff(self.edges).reshape(self.K, self.size).sum(axis=0)

    @cached_property
    def widths(self):
        """The numbers of columns that are transformed at a time."""
        return sorted({int(w) for w in np.diff(self.edges) if w and self.size > 1} | {self.W})

    @property
    def scratch_bytes(self):
        """Bytes that each thread has for itself."""
        rows = self.R * (self.n[1] * self.itemsize // 2 + self.n_c * self.itemsize)
        return rows + self.W * self.n[0] * self.itemsize * (2 if self.size > 1 else 1)

    @property
    def bytes(self):
        """Bytes of the spectrum on this rank."""
        return self.n_loc * self.n_c * self.itemsize

    def sent(self, k):
        """Bytes to every rank, and their offsets in the slab of the all-to-all number k."""
        edges = self.edges[k * self.size:(k + 1) * self.size + 1]
        return np.diff(edges) * (self.n_loc * self.itemsize), (edges[:-1] - edges[0]) * (self.n_loc * self.itemsize)

    def received(self, k):
        """Bytes from every rank of complete columns, and their offsets."""
        j0, j1 = self.columns_of(k * self.size + self.rank)
        return np.diff(self.starts) * ((j1 - j0) * self.itemsize), self.starts[:-1] * ((j1 - j0) * self.itemsize)

    def traffic(self):
        """(bytes, messages) that this rank sends to others in a transform there and back."""
        widths, mine, rows = np.diff(self.edges), self.columns_held[self.rank], np.diff(self.starts)
        nbytes = (self.n_loc * (self.n_c - mine) + (self.n[0] - self.n_loc) * mine) * self.itemsize
        blocks, of_others = np.count_nonzero(widths[self.rank::self.size]), np.count_nonzero(rows) - (self.n_loc > 0)
        there = (np.count_nonzero(widths) - blocks) * (self.n_loc > 0)
        return int(nbytes), int(there + blocks * of_others)


class SlabFFT(Layout):
    """Transforms of one grid in one precision.

    n: (n_x, n_y) global; starts: first row of each rank plus n_x; dtype: of the real field; threads: of this rank.
    """

    def __init__(self, comm, n, starts, dtype, threads=1):
        self.comm, self.dtype = comm, np.dtype(dtype)
        complex_dtype = np.result_type(self.dtype, np.complex64)
        super().__init__(n, starts, comm.rank, complex_dtype.itemsize)
        n_x, n_y = n
        self.scale = 1.0 / (n_x * n_y)
        self.threads = threads
        self._pool = ThreadPoolExecutor(threads) if threads > 1 else None
        self.blocks = zeros_aligned((self.n_loc * self.n_c,), complex_dtype)
        self._scratch = []
        for _ in range(threads):
            received = (n_x * self.W,) if comm.size > 1 else (0,)
            self._scratch.append((zeros_aligned((self.R, n_y), self.dtype), zeros_aligned((self.R, self.n_c), complex_dtype),
                                  zeros_aligned((self.W, n_x), complex_dtype), zeros_aligned(received, complex_dtype)))
        real, half, columns, _ = self._scratch[0]
        self._rounds = [(self.sent(k), self.received(k)) for k in range(self.K)]
        self.plans = planned(comm, self.dtype, lambda: Plans(real, half, [columns[:w] for w in self.widths]),
                             (real.shape, columns.shape, *self.widths))
        for a in (real, half, columns):
            a[...] = 0  # planning has left noise

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

    def forward_rows(self, fill, passes=None):
        """Transform rows made by fill(i0, i1, x), x: (R, n_y) scratch; returns what fill recolumns, in the order of the passes."""

        def one(i0, i1, scratch):
            real, half = scratch[:2]
            result = fill(i0, i1, real)
            self.plans.rows_forward(real, half)
            to_blocks(half, self.blocks, self.edges, self.n_loc, i0, i1 - i0)
            return result

        return self._map(one, passes or self.passes())

    def backward_rows(self, use, passes=None):
        """Hand the rows of the real field to use(i0, i1, x), x: (R, n_y) scratch; returns what use recolumns, in order."""

        def one(i0, i1, scratch):
            real, half = scratch[:2]
            from_blocks(self.blocks, half, self.edges, self.n_loc, i0, i1 - i0)
            self.plans.rows_backward(half, real)
            return use(i0, i1, real)

        return self._map(one, passes or self.passes())

    def columns(self, apply, forward=True, backward=True):
        """Call apply(block, m) on every block of complete columns of this rank, block: (width, n_x); returns the results in order.

        forward/backward=False leaves out the transform along axis 0 (and the all-to-all) on that side; a block that was not
        transformed forward is all zero.
        """
        if self.comm.size > 1:
            return self._columns_mpi(apply, forward, backward)

        def one(m, _, scratch):
            return self._one_block(self._slab(m, m + 1), scratch[2], m, apply, forward, backward)

        return self._map(one, [(m, m) for m in range(self.M)])

    def _slab(self, first, last):
        """The memory of some blocks of this rank's rows."""
        return self.blocks[self.n_loc * self.edges[first]:self.n_loc * self.edges[last]]

    def _one_block(self, block, columns, m, apply, forward, backward):
        """block: complete columns as they are stored, rows of them one after another."""
        j0, j1 = self.columns_of(m)
        width = j1 - j0
        block = block[:width * self.n[0]].reshape(self.n[0], width)
        for_plan = columns[:next(w for w in self.widths if w >= width)]  # as many as there is a plan for
        columns = for_plan[:width]
        if forward:
            for_plan[width:] = 0
            transpose(_moved(block), _moved(columns))
            self.plans.columns_forward(for_plan)
        else:
            for_plan[...] = 0
        result = apply(columns, m)
        if backward:
            self.plans.columns_backward(for_plan)
            transpose_back(_moved(columns), _moved(block))
        return result

    def _columns_mpi(self, apply, forward, backward):
        results = []
        for k0 in range(0, self.K, self.threads):
            group = range(k0, min(k0 + self.threads, self.K))
            for k, scratch in zip(group, self._scratch):
                if forward:
                    sent, received = self._rounds[k]
                    self.comm.alltoall_bytes((self._round(k), *sent), (scratch[3], *received))

            def one(k, first, _):
                _, _, columns, block = self._scratch[k - first]
                return self._one_block(block, columns, k * self.size + self.rank, apply, forward, backward)

            results += self._map(one, [(k, k0) for k in group if self._rounds[k][1][0].any()])
            for k, scratch in zip(group, self._scratch):
                if backward:
                    sent, received = self._rounds[k]
                    self.comm.alltoall_bytes((scratch[3], *received), (self._round(k), *sent))
        return results

    def _round(self, k):
        """The memory of the blocks that go out in the all-to-all number k."""
        return self._slab(k * self.size, (k + 1) * self.size)

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
