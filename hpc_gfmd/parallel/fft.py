"""Slab-decomposed two-dimensional real FFT in passes over cache-sized pieces.

Every rank owns a slab of rows of the real field. Callers hand in functions for a few rows or
columns at a time, or compiled passes that call the transforms (kernels/transforms.py); one complex
field is all the memory that a convolution needs:

    forward_rows(fill)    fill(i0, i1, x) makes rows i0..i1 of the real field -> row spectra
    columns(apply)        transpose a block of columns, transform it, apply(block, m), and back
    backward_rows(use)    use(i0, i1, x) gets rows i0..i1 of the convolved field

The columns are cut into M blocks, of which block m = k P + r belongs to rank r; row spectra are
stored block by block. A block is transposed to contiguous columns (width, n_x), which transform up
to twice as fast. Its parts on the same node are read and written in common memory (shared.py), the
others are sent in the all-to-all number k, whose send buffers are contiguous as they stand.

Convention: h_q = (1/N) sum_r h(r) exp(-i q r), h(r) = sum_q h_q exp(i q r). The transforms leave
out 1/N in both directions; `scale` = 1/N is folded into the kernels that work on columns.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from ..kernels.spectral import multiply_blocks
from ..kernels.transforms import load_columns, load_rows, store_columns, store_rows
from ..util.aligned import empty_aligned, zeros_aligned
from .fftw import Plans
from .layout import Layout
from .shared import common_memory
from .threads import Shares, on_threads, shares
from .wisdom import planned

if TYPE_CHECKING:
    from .comm import Comm

T = TypeVar("T")
RowWork = Callable[[int, int, np.ndarray], T]  # makes or uses local rows i0 <= i < i1 in x (R, n_y)


class SlabFFT(Layout):
    """Transforms of one grid in one precision, planned when the object is made: collective.

    `blocks` holds one spectrum, this rank's row spectra block by block, overwritten by
    `forward_rows`, `columns` and `multiply_columns` (unless without `backward`). `rows` and
    `_columns` are what kernels take, by thread; `multipliers` is where bodies keep what they
    multiply columns by.
    """

    def __init__(
        self, comm: Comm, n: tuple[int, int], starts: ArrayLike, dtype: DTypeLike, threads: int = 1
    ):
        self.comm = comm
        self.dtype: np.dtype = np.dtype(dtype)
        complex_dtype = np.result_type(self.dtype, np.complex64)
        super().__init__(n, starts, comm.rank, complex_dtype.itemsize, comm.node_ranks)
        n_x, n_y = n
        self.scale = 1.0 / (n_x * n_y)
        self.threads = threads
        self.multipliers: dict[Any, Any] = {}
        self._own_widths = self.block_widths[:, self.rank].tolist()
        self._memory, self._offsets, self.blocks = self._common(complex_dtype)
        received = n_x * self.W if self.far.any() else 0
        self._scratch = [  # of a thread: real rows, their spectra, columns, what has been sent
            (
                zeros_aligned((self.R, n_y), self.dtype),
                zeros_aligned((self.R, self.n_c), complex_dtype),
                zeros_aligned((self.W, n_x), complex_dtype),
                zeros_aligned((received,), complex_dtype),
            )
            for _ in range(threads)
        ]
        real, half, columns, _ = self._scratch[0]
        self.plans = planned(
            comm,
            self.dtype,
            lambda: Plans(real, half, [columns[:w] for w in self.widths]),
            (real.shape, columns.shape, *self.widths),
        )
        for a in (real, half, columns):
            a[...] = 0  # planning has left noise
        self.rows = [self._rows_of(scratch) for scratch in self._scratch]
        self._columns = self._columns_of_threads()

    def _common(self, dtype: np.dtype) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the node's shared memory for a spectrum, where each rank's part begins, and this
        rank's part (its rows of all blocks). Collective.
        """
        node = self.comm.node
        length = self.n_loc * self.n_c
        if node.size == 1:
            blocks = empty_aligned((length,), dtype)  # a pass writes all of them
            return blocks, np.zeros(1, int), blocks
        memory_bytes, byte_offsets = common_memory(node, length * dtype.itemsize)
        memory = memory_bytes.view(dtype)
        offsets = byte_offsets // dtype.itemsize
        blocks = memory[offsets[node.rank] :][:length]
        blocks[...] = 0  # every rank its own: pages belong where they are touched first
        return memory, offsets, blocks

    def _rows_of(self, scratch: tuple[np.ndarray, ...]) -> tuple:
        """Return `rows` of the thread with some scratch, see kernels/transforms.py."""
        real, half, _, _ = scratch
        spectra = (
            half.view(np.float64).reshape(-1),
            self.blocks.view(np.float64),
            self.edges * (half.itemsize // 8),
            self.n_loc,
            (*self.plans.rows_forward, real.ctypes.data, half.ctypes.data),
            (*self.plans.rows_backward, half.ctypes.data, real.ctypes.data),
        )
        return real, spectra

    def _columns_of_threads(self) -> list[tuple]:
        """Return `columns` of each thread, see kernels/transforms.py."""
        forward = self.plans.columns_forward
        backward = self.plans.columns_backward
        of_widths = np.array([(w, forward[w][1], backward[w][1]) for w in self.widths])
        # a block of another width uses the plan for the next larger one
        plans = of_widths[np.searchsorted(self.widths, self._own_widths)]
        near_rows, far_rows = (
            np.stack([self.starts[ranks], self.starts[ranks + 1]], axis=1)
            for ranks in (self.node_ranks, np.flatnonzero(self.far))
        )
        first_columns = self.edges[:-1].reshape(self.blocks_per_rank, self.size)[:, self.rank]
        near_begins = self._offsets + np.diff(near_rows)[:, 0] * first_columns[:, None]
        far_begins = np.outer(self._own_widths, far_rows[:, 0])
        return [
            (
                _moved(columns),
                columns.ctypes.data,
                (_moved(self._memory), near_begins, near_rows),
                (_moved(received), far_begins, far_rows),
                forward[self.W][0],
                np.column_stack([self._own_widths, plans]),
            )
            for _, _, columns, received in self._scratch
        ]

    def passes(self) -> list[tuple[int, int]]:
        """Return the ranges (i0, i1) of local rows that are transformed at a time."""
        return [(i, min(i + self.R, self.n_loc)) for i in range(0, self.n_loc, self.R)]

    def forward_rows(self, fill: RowWork[T]) -> list[T]:
        """Transform the rows that fill(i0, i1, x) writes into x, on threads, into `blocks`; return
        its results by pass. Not collective.
        """

        def forward(i0: int, i1: int, rows: tuple) -> T:
            result = fill(i0, i1, rows[0])
            store_rows(rows[1], i0, i1)
            return result

        return on_threads(self.threads, forward, self.passes(), self.rows)

    def backward_rows(self, use: RowWork[T]) -> list[T]:
        """Transform `blocks` back and hand local rows to use(i0, i1, x). Not collective."""

        def backward(i0: int, i1: int, rows: tuple) -> T:
            load_rows(rows[1], i0, i1)
            return use(i0, i1, rows[0])

        return on_threads(self.threads, backward, self.passes(), self.rows)

    def forward_passes(
        self, work: Callable[[np.ndarray, np.ndarray, np.ndarray, tuple], Any]
    ) -> None:
        """Transform the rows of a kernel, work(passes (passes, 2), parts, turns, rows) on each
        thread, into `blocks`. Not collective.
        """
        passes = np.array(self.passes(), np.int64).reshape(-1, 2)
        parts = Shares(len(passes), self.threads)
        parts.on_threads(partial(work, passes, parts.parts, parts.turns), self.rows)

    def first_columns(self, count: int) -> np.ndarray:
        """Return a copy (n_loc, count) of the first columns of the row spectra in `blocks`."""
        blocks = [
            self._slab(m, m + 1).reshape(self.n_loc, self.edges[m + 1] - self.edges[m])
            for m in range(np.searchsorted(self.edges, count))
        ]
        return np.concatenate(blocks, axis=1)[:, :count]

    def columns(
        self, apply: Callable[[np.ndarray, int], T], forward: bool = True, backward: bool = True
    ) -> list[T]:
        """Call apply(block, m), which may change it, on this rank's blocks (width, n_x) of complete
        columns; return its results. Collective. Without `forward` blocks are zeros, without
        `backward` they are lost.
        """
        results: list[Any] = [None] * self.blocks_per_rank

        def work(k0: int, k1: int, columns: tuple) -> None:
            block = columns[0].view(self.blocks.dtype)
            for k in range(k0, k1):
                if self._own_widths[k]:
                    if forward:
                        load_columns(columns, k)
                    else:
                        columns[0][...] = 0
                    results[k] = apply(block[: self._own_widths[k]], k * self.size + self.rank)
                    if backward:
                        store_columns(columns, k)

        self._on_blocks(work, forward, backward)
        return [result for result, width in zip(results, self._own_widths) if width]

    def multiply_columns(
        self, factors: tuple, inverse: bool, backward: bool
    ) -> tuple[float, float]:
        """Apply K, or `inverse` 1/K, to the field u whose row spectra are in `blocks`. Collective.

        Returns this rank's share of the sum of u K u, or u (u/K), over points, and on rank 0 the
        mean of u. factors: as of kernels/spectral.py: multiply_blocks; without `backward` `blocks`
        keeps the spectra.
        """
        sums = np.zeros((self.blocks_per_rank, 2))

        def multiply(parts: np.ndarray, turns: np.ndarray, columns: tuple) -> None:
            numbers = columns[0].view(self.dtype)
            multiply_blocks(columns, parts, turns, numbers, factors, inverse, backward, sums)

        def work(k0: int, k1: int, columns: tuple) -> None:
            multiply(np.array([[k0, k1]]), np.zeros(1, np.int64), columns)

        if self.far.any():  # what other nodes have of a block is in the scratch of one thread
            self._on_blocks(work, True, backward)
        else:
            self.comm.node.barrier()  # all rows of the node are there
            blocks = Shares(self.blocks_per_rank, self.threads)
            blocks.on_threads(partial(multiply, blocks.parts, blocks.turns), self._columns)
            self.comm.node.barrier()  # all columns are back
        return sum(sums[:, 0].tolist()), float(sums[0, 1]) * self.scale * (self.rank == 0)

    def _on_blocks(
        self, work: Callable[[int, int, tuple], None], forward: bool, backward: bool
    ) -> None:
        """Call work(k0, k1, columns) for all blocks on all threads, with rows fetched from other
        nodes before and sent after; a node's ranks wait for each other. Collective.
        """
        self.comm.node.barrier()  # all rows of the node are there
        if self.far.any():
            for k0 in range(0, self.blocks_per_rank, self.threads):
                group = range(k0, min(k0 + self.threads, self.blocks_per_rank))
                if forward:
                    self._exchange(group, back=False)
                on_threads(self.threads, work, [(k, k + 1, self._columns[k - k0]) for k in group])
                if backward:
                    self._exchange(group, back=True)
        else:
            on_threads(
                self.threads, work, shares(self.blocks_per_rank, self.threads), self._columns
            )
        self.comm.node.barrier()  # all columns are back

    def _exchange(self, group: range, back: bool) -> None:
        """Fetch rows of blocks k in `group` (at most one a thread) from other nodes, or send them
        `back`; block k is in the scratch of thread k - group.start. Collective.
        """
        for k, scratch in zip(group, self._scratch):
            blocks = self._slab(k * self.size, (k + 1) * self.size)
            ends = (blocks, *self.sent(k)), (scratch[3], *self.received(k))
            self.comm.alltoall_bytes(*(reversed(ends) if back else ends))

    def _slab(self, m0: int, m1: int) -> np.ndarray:
        """Return the part of `blocks` that holds blocks m0 <= m < m1 of all ranks, a flat view."""
        return self.blocks[self.n_loc * self.edges[m0] : self.n_loc * self.edges[m1]]


def _moved(a: np.ndarray) -> np.ndarray:
    """View complex64 as float64, which the compiler moves in one piece."""
    return a.view(np.float64) if a.dtype == np.complex64 else a
