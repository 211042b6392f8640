"""Rows and columns of each rank, and what ranks have to send each other: for fft.py.

A rank has a slab of rows of the real field and, of the half spectrum, blocks of columns, dealt out
to the ranks in turn. Rows are transformed a pass at a time, columns a block at a time, both of a
size that the second-level cache holds.
"""

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

COLUMN_BYTES = 256 * 1024  # of a block of columns, which is transposed in the second-level cache
# of the spectra of one pass of rows: these share the second-level cache with the rows of the
# caller's fields
ROW_BYTES = 256 * 1024
MIN_WIDTH = 8  # columns of a block
MAX_WIDTH = 64


def row_starts(n_x: int, size: int) -> np.ndarray:
    """Return the first row of every rank, and n_x: the block distribution of mpi4py-fft."""
    return np.array([r * (n_x // size) + min(r, n_x % size) for r in range(size + 1)])


class Layout:
    """The rows of a field and the columns of its half spectrum that each rank has; sends nothing.

    - n: points along x and y; starts: first row of every rank, and n_x. `n_loc`: rows of this rank;
      `R`: how many of them a pass transforms.
    - `n_c`: columns of the half spectrum; `edges`: first column of every block, and n_c. Block
      k size + r is block k of rank r; `block_widths` (blocks_per_rank, size): columns of each; `W`:
      of the widest.
    - node_ranks: the ranks that share memory with this one, itself among them; `far` (size,): the
      ranks that do not, which have to be sent their parts.
    - itemsize: bytes of a complex number.
    """

    def __init__(
        self,
        n: Sequence[int],
        starts: ArrayLike,
        rank: int,
        itemsize: int,
        node_ranks: ArrayLike | None = None,
    ):
        self.n = n
        self.starts = np.asarray(starts)
        self.rank = rank
        self.itemsize = itemsize
        self.size = len(self.starts) - 1
        self.n_c = n[1] // 2 + 1
        self.n_loc = int(self.starts[rank + 1] - self.starts[rank])
        self.edges = self._edges()
        self.blocks_per_rank = (len(self.edges) - 1) // self.size
        self.block_widths = np.diff(self.edges).reshape(self.blocks_per_rank, self.size)
        self.W = int(self.block_widths.max())
        self.R = self._rows_per_pass()
        self.node_ranks = np.array([rank] if node_ranks is None else node_ranks)
        self.far = np.ones(self.size, bool)
        self.far[self.node_ranks] = False

    def _edges(self) -> np.ndarray:
        """Return the first columns of blocks that fit the cache, and n_c. Ranks have as many
        blocks, one column wider at most, the wider last so that others begin on cache lines; one
        rank has whole cache lines.
        """
        wanted = int(np.clip(COLUMN_BYTES // (self.n[0] * self.itemsize), MIN_WIDTH, MAX_WIDTH))
        if self.size > 1:
            blocks = self.size * max(1, round(self.n_c / self.size / wanted))
            edges = row_starts(self.n_c, blocks)
            # q = 0 is in block 0
            return edges if self.n_c < blocks else self.n_c - edges[::-1]
        blocks = -(-self.n_c // wanted)
        width = -(-self.n_c // blocks)
        if blocks > 1:
            line = 64 // self.itemsize  # complex numbers in a cache line
            width = -(-width // line) * line
        return np.append(np.arange(0, self.n_c, width), self.n_c)

    def _rows_per_pass(self) -> int:
        """Return how many rows to transform at a time to fit the cache, equal on all ranks."""
        wanted = int(np.clip(ROW_BYTES // (self.n_c * self.itemsize), 8, 256))
        longest = int(np.diff(self.starts).max())  # on any rank: all plan alike
        passes = max(1, -(-longest // wanted))
        R = max(1, -(-longest // passes))
        return R + R % 2 if R > 1 else R  # even: a coarse row then belongs to one pass

    def columns_of(self, m: int) -> tuple[int, int]:
        """Return the columns (begin, end) of the half spectrum that block m holds."""
        return int(self.edges[m]), int(self.edges[m + 1])

    @cached_property
    def widths(self) -> list[int]:
        """Numbers of columns that have plans, ascending; a block uses the next larger one."""
        if self.size == 1:
            return [self.W]
        return np.unique(self.block_widths[self.block_widths > 0]).tolist()

    def sent(self, k: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the bytes to every rank (0 on this node) in all-to-all k, and their offsets."""
        first_columns = self.edges[k * self.size : (k + 1) * self.size]
        column_bytes = self.n_loc * self.itemsize
        sizes = self.far * self.block_widths[k] * column_bytes
        return sizes, (first_columns - first_columns[0]) * column_bytes

    def received(self, k: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the bytes from every rank in all-to-all k, and their offsets."""
        row_bytes = self.block_widths[k, self.rank] * self.itemsize
        return self.far * np.diff(self.starts) * row_bytes, self.starts[:-1] * row_bytes
