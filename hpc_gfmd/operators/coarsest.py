"""The coarse levels that one rank sweeps alone, in one compiled call of all its threads.

A sweep is equation (5) in docs/method.md on these levels, down to a single point: r and t are
restricted to each, then z is made on each, coarsest first. All levels are parts of one array, and
the sweep is a list of pieces, some rows of a level each, which threads take in turn
(kernels/multilevel.py: sweep_levels).
"""

import time
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ..kernels.multilevel import CLOSED, ENDED, MEAN, NEXT, SUMS, TOTALS, TURNS, sweep_levels
from ..parallel.coarsening import Level, axis_mode, axis_tables, passes_of
from ..parallel.threads import PIECE_POINTS, on_threads, piece_rows, threads_for
from ..util.aligned import empty_aligned, zeros_aligned

# c in (5): how much contact stiffens a level. Measured on self-affine walls of n = 512 and 1024:
# within 2 % of the fewest pairs from 2.5 to 3, 5 % more at 4
DAMPING = 3.0
# A sweep over coarse levels has less to do than a pass over the grid: smaller pieces share it out.
PIECES = 8  # of a sweep, in a piece of a pass
# A thread that waits for others looks so often, 0.2 ms, before it lets the system have its core
PATIENCE = 2**14
PAUSE = 1e-5  # seconds


class LevelTables:
    """What `sweep_levels` (kernels/multilevel.py) needs of consecutive levels besides memory.

    weights, softness: of each level, as of Body. fields: 2 (r, t) or 3 (and x) on the first level;
    the others have 2. nominal: the factors (s_x, s_y) of the surface's indicator on each level,
    default 1. `size`: how many numbers the fields of all levels take; the last `zeros` of them are
    a level of zeros below the coarsest. `pieces`: see `_pieces_of`; the first `restricted` of them
    restrict.
    """

    def __init__(
        self,
        levels: Sequence[Level],
        weights: np.ndarray,
        softness: ArrayLike,
        fields: int = 2,
        nominal: Sequence[Sequence[np.ndarray]] | None = None,
    ):
        dtype = self.dtype = weights.dtype
        shapes = [level.n for level in levels]
        coarser = [*shapes[1:], shapes[-1]]
        counts = [fields] + [2] * (len(levels) - 1) + [1]
        sizes = [
            count * (n_x + 2) * n_y for count, (n_x, n_y) in zip(counts, [*shapes, shapes[-1]])
        ]
        begins = np.cumsum([0, *sizes])
        self.size = int(begins[-1])
        self.zeros = sizes[-1]
        self.points = shapes[0][0] * shapes[0][1]
        self.longest_row = max(n_y for _, n_y in shapes)
        rows_before = np.cumsum([0, *(n_x for n_x, _ in shapes)])
        columns_before = np.cumsum([0, *(n_y for _, n_y in shapes)])
        along = [axis_mode(n[1], m[1]) for n, m in zip(shapes, coarser)] + [0]
        rows, columns = (
            [axis_tables(n[axis], m[axis], dtype) for n, m in zip(shapes, coarser)]
            for axis in (0, 1)
        )
        self.pieces, self.restricted = _pieces_of(shapes, [J_x for J_x, _ in rows])
        self.levels = np.array(
            [
                (begin, count, n_x, n_y, mode, at_x, at_y)
                for begin, count, (n_x, n_y), mode, at_x, at_y in zip(
                    begins, counts, [*shapes, shapes[-1]], along, rows_before, columns_before
                )
            ],
            np.int64,
        )
        if nominal is None:
            nominal = [[np.ones(n_x), np.ones(n_y)] for n_x, n_y in shapes]
        self.tables = (
            np.concatenate([J_x + np.int32(1) for J_x, _ in rows]),
            np.concatenate([f_x for _, f_x in rows]),
            np.concatenate([J_y for J_y, _ in columns]),
            np.concatenate([f_y for _, f_y in columns]),
            np.concatenate([s_x for s_x, _ in nominal]).astype(dtype),
            np.concatenate([s_y for _, s_y in nominal]).astype(dtype),
        )
        factors = [m[0] / n[0] * m[1] / n[1] for n, m in zip(shapes, coarser)]
        self.numbers = np.array([weights, factors], dtype).T.copy()
        self.softness = np.asarray(softness, np.float64)


def _pieces_of(
    shapes: Sequence[tuple[int, int]], coarse_rows: Sequence[np.ndarray]
) -> tuple[np.ndarray, int]:
    """Return the pieces of a sweep (`sweep_levels`), by sizes alone, and how many restrict."""
    passes = [
        passes_of(J_x, max(1, piece_rows(n_y) // PIECES))
        for (_, n_y), J_x in zip(shapes, coarse_rows)
    ]
    down = [(k, False) for k in range(len(shapes) - 1)]
    up = [(k, True) for k in reversed(range(len(shapes)))]
    pieces: list[tuple] = []
    for k, is_smoothed in down + up:
        stage = len(pieces), len(pieces) + len(passes[k])
        pieces += [(k, i0, i1, is_smoothed, *stage) for i0, i1 in passes[k]]
    return np.array(pieces, np.int64), sum(len(passes[k]) for k, _ in down)


class CoarsestLevels:
    """Consecutive levels, down to a single point, that one rank sweeps alone, with their memory.

    Before a sweep the caller writes r, t, perhaps x to `fields`, those of the first level, between
    halo rows; the sweep replaces r by z, also in the halo rows. `mode`: the gap mode
    (deflation.py), flat, on level `mode_level`; empty without one.
    """

    def __init__(self, tables: LevelTables, threads: int = 1):
        dtype = tables.dtype
        self._tables = tables
        self._damping = np.array([DAMPING], dtype)[0]
        self._memory = empty_aligned((tables.size,), dtype)
        self._memory[-tables.zeros :] = 0
        self._threads = threads_for(tables.points, threads, PIECE_POINTS)
        self._scratch = [
            tuple(empty_aligned((2, tables.longest_row), dtype)) for _ in range(self._threads)
        ]
        self._turns = zeros_aligned((TURNS,), np.int64)
        self._sums = np.empty((len(tables.pieces), SUMS))
        self._totals = np.empty(TOTALS)
        self.fields = self._fields_of(0)
        self.mode = np.zeros(0, dtype)
        self.mode_level = 0

    def sweep(self) -> tuple[float, ...]:
        """Restrict r and t to all levels, replace r by z on each; return what `smooth` does."""
        self._do(0, len(self._tables.pieces))
        return tuple(self._totals[: MEAN + 1].tolist())

    def restrict(self) -> None:
        """Restrict r and t of the first level to all coarser ones, in the memory of this object."""
        self._do(0, self._tables.restricted)

    def smooth(self) -> tuple[float, ...]:
        """Replace r by z on every level, coarsest first, after `restrict`; return <r, z>, <x, z>
        (first level), then <r, r>, <t, t>, <r, t>, <t, s>, <r, s> times softness, and the mean of
        r.
        """
        self._do(self._tables.restricted, len(self._tables.pieces))
        return tuple(self._totals[: MEAN + 1].tolist())

    def _do(self, begin: int, end: int) -> None:
        """Do the pieces begin <= piece < end of a sweep, on all threads at the same time."""
        self._turns[[NEXT, ENDED, CLOSED]] = begin

        def work(scratch: tuple[np.ndarray, ...]) -> None:
            while not self._do_some(end, scratch):
                time.sleep(PAUSE)

        on_threads(self._threads, work, [()] * self._threads, self._scratch)

    def _do_some(self, end: int, scratch: tuple[np.ndarray, ...]) -> bool:
        """Do pieces on one thread until `end`; return what the kernel sweep_levels does."""
        tables = self._tables
        return sweep_levels(
            tables.pieces,
            end,
            self._turns,
            PATIENCE,
            self._memory,
            tables.levels,
            tables.tables,
            tables.numbers,
            tables.softness,
            self._damping,
            self.mode,
            self.mode_level,
            scratch,
            self._sums,
            self._totals,
        )

    def apply(self, r: np.ndarray, t: np.ndarray) -> np.ndarray:
        """Copy r and t into `fields`, sweep, and return z on the first level, a view of these."""
        self.fields[0, 1:-1] = r
        self.fields[1, 1:-1] = t
        self.sweep()
        return self.fields[0, 1:-1]

    def contact(self, k: int) -> np.ndarray:
        """Return a view of t of level k, (rows, n); the caller writes that of level 0."""
        return self._fields_of(k)[1, 1:-1]

    def _fields_of(self, k: int) -> np.ndarray:
        """Return the fields of level k with their halo rows, (fields, rows + 2, n), a view."""
        begin, count, rows, n = self._tables.levels[k, :4].tolist()
        return self._memory[begin : begin + count * (rows + 2) * n].reshape(count, rows + 2, n)
