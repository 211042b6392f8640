"""The periodic grid, its slabs, wave vectors and sums over ranks.

Convention of the discrete Fourier transform, used everywhere, with q of the minimal image:

    h_q = (1/N) sum_r h(r) exp(-i q.r),    h(r) = sum_q h_q exp(+i q.r),    N = n_x n_y
    h_rms^2 = sum_{q != 0} |h_q|^2,        g_rms^2 = sum_q q^2 |h_q|^2

In-plane lengths inside the program are in units of the grid spacing a = sqrt(a_x a_y).
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Hashable, Sequence
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from ..util.aligned import empty_aligned
from .fft import SlabFFT
from .layout import row_starts
from .threads import on_threads, pieces_of

if TYPE_CHECKING:
    from .comm import Comm

T = TypeVar("T")

KEPT = 16  # sizes of grids whose tables a thread keeps
SMALL = 2**25  # bytes of transforms below which making them anew costs more than keeping them


class GridTables:
    """SlabFFT by dtype, and `values` of `Grid.once` by key, for all grids of a size."""

    def __init__(self) -> None:
        self.transforms: dict[np.dtype, SlabFFT] = {}
        self.values: dict[Hashable, Any] = {}


class Grid:
    """A periodic grid; every rank owns the rows [start, stop) of each field.

    Parameters
    ----------
    n : (int, int)
        Points (n_x, n_y) of the whole grid.
    sizes : (float, float)
        Physical lengths (L_x, L_y) of the cell.
    comm : Comm, optional
        Communicator of the ranks; by default this process alone.
    threads : int
        Threads of this rank.
    starts : array of int, optional
        First row of each rank, and n_x at the end; by default the block distribution of mpi4py-fft.
    nominal : (int, int), optional
        Points along each axis that the surface has, from point 0; by default all. The others are
        padding, where nothing can touch. Means and counts are over the nominal area.
    tables : GridTables, optional
        Transforms and tables of a grid of the same size; by default new ones are made.
    """

    def __init__(
        self,
        n: Sequence[int],
        sizes: Sequence[float] = (1.0, 1.0),
        comm: Comm | None = None,
        threads: int = 1,
        starts: ArrayLike | None = None,
        nominal: Sequence[int] | None = None,
        tables: GridTables | None = None,
    ):
        from .comm import SerialComm

        self.n = (int(n[0]), int(n[1]))
        self.sizes = (float(sizes[0]), float(sizes[1]))
        self.comm = comm or SerialComm()
        self.threads = threads
        self.starts = (
            row_starts(self.n[0], self.comm.size) if starts is None else np.asarray(starts)
        )
        self.nominal = self.n if nominal is None else (int(nominal[0]), int(nominal[1]))
        self._tables = tables or GridTables()

    @classmethod
    def kept(
        cls,
        n: Sequence[int],
        sizes: Sequence[float],
        comm: Comm,
        threads: int = 1,
        starts: ArrayLike | None = None,
        nominal: Sequence[int] | None = None,
    ) -> Grid:
        """Make a grid that shares transforms, tables and scratch memory with earlier ones of its
        size, in one thread of one process; the last KEPT sizes are kept.
        """
        if comm.size > 1 or comm.parent is not None:
            return cls(n, sizes, comm, threads, starts, nominal)
        ends = None if nominal is None else tuple(map(int, nominal))
        tables = _kept.tables(tuple(map(int, n)), tuple(map(float, sizes)), threads, ends)
        return cls(n, sizes, comm, threads, None, nominal, tables)

    @property
    def cell_points(self) -> int:
        """Number of points of the whole grid."""
        return self.n[0] * self.n[1]

    @property
    def N(self) -> int:
        """Number of points of the nominal area: all, unless the surface ends within the grid."""
        return self.nominal[0] * self.nominal[1]

    @property
    def nominal_sizes(self) -> tuple[float, ...]:
        """(L_x, L_y) of the nominal area."""
        return tuple(size * m / k for size, m, k in zip(self.sizes, self.nominal, self.n))

    @property
    def padded(self) -> bool:
        """Whether the grid has points beyond the surface."""
        return self.nominal != self.n

    @property
    def inside(self) -> tuple[int, int]:
        """(rows, points) of this rank's nominal area: first local rows, first points of each."""
        start, stop = self.nominal_rows
        return stop - start, self.nominal[1]

    @property
    def nominal_rows(self) -> tuple[int, int]:
        """This rank's rows of the nominal area, by global numbers (start, stop), perhaps none."""
        start, stop = self.rows
        return min(start, self.nominal[0]), min(stop, self.nominal[0])

    @cached_property
    def rows(self) -> tuple[int, int]:
        """This rank's rows of the grid, by global numbers (start, stop)."""
        r = self.comm.rank
        return int(self.starts[r]), int(self.starts[r + 1])

    @property
    def shape(self) -> tuple[int, int]:
        """Shape of a local slab."""
        start, stop = self.rows
        return stop - start, self.n[1]

    @property
    def spacings(self) -> tuple[float, float]:
        """Physical grid spacings (a_x, a_y)."""
        return self.sizes[0] / self.n[0], self.sizes[1] / self.n[1]

    @cached_property
    def a(self) -> float:
        """The unit of in-plane length, sqrt(a_x a_y)."""
        return float(np.sqrt(self.spacings[0] * self.spacings[1]))

    @cached_property
    def q_x(self) -> np.ndarray:
        """Wave numbers along x in units of 1/a, shape (n_x,)."""
        return 2 * np.pi * np.fft.fftfreq(self.n[0]) * self.a / self.spacings[0]

    @cached_property
    def q_y(self) -> np.ndarray:
        """Wave numbers along y of the half spectrum in units of 1/a, shape (n_y//2 + 1,)."""
        return 2 * np.pi * np.arange(self.n[1] // 2 + 1) / self.n[1] * self.a / self.spacings[1]

    @cached_property
    def q_nyquist(self) -> float:
        """|q| at the corner of the Brillouin zone over sqrt 2, in 1/a; 1 for a single point."""
        q = [np.pi * self.a / s for s, n in zip(self.spacings, self.n) if n > 1]
        return float(np.sqrt(sum(x * x for x in q) / 2)) or 1.0

    def multiplicity(self, j: ArrayLike) -> np.ndarray:
        """Return how often columns j of the half spectrum occur in the full one: 0, 1 or 2."""
        j = np.asarray(j)
        n_y = self.n[1]
        twice = (j > 0) & (2 * j != n_y)
        return np.where(j > n_y // 2, 0, np.where(twice, 2, 1))

    def fft(self, dtype: DTypeLike) -> SlabFFT:
        """Return the transforms in one precision, planned at the first call. Collective."""
        dtype = np.dtype(dtype)
        transforms = self._tables.transforms
        if dtype not in transforms:
            transforms[dtype] = SlabFFT(self.comm, self.n, self.starts, dtype, self.threads)
        return transforms[dtype]

    def planned(self) -> list[SlabFFT]:
        """Return the transforms that exist at present, in any precision."""
        return list(self._tables.transforms.values())

    def forget_fft(self, dtype: DTypeLike) -> None:
        """Forget the transforms in one precision if their spectrum takes more than SMALL bytes."""
        fft = self._tables.transforms.get(np.dtype(dtype))
        if fft is not None and fft.blocks.nbytes > SMALL:
            del self._tables.transforms[fft.dtype]

    def empty(self, dtype: DTypeLike) -> np.ndarray:
        """Make an uninitialised local slab."""
        return empty_aligned(self.shape, dtype)

    def pieces(self, rows: int | None = None) -> tuple[tuple[int, int], ...]:
        """List the ranges (i0, i1) of the first `rows` local rows that a thread takes at a time."""
        rows = self.shape[0] if rows is None else rows
        return pieces_of(rows, self.n[1])

    def by_rows(self, work: Callable[[int, int], T], rows: int | None = None) -> list[T]:
        """Return what work(i0, i1) gives for each of the `pieces` of local rows. Not collective."""
        return on_threads(self.threads, work, self.pieces(rows))

    def once(self, key: Hashable, make: Callable[[], T]) -> T:
        """Return make() of the first call with this key, which with the grid's size determines the
        shared value: do not change it.
        """
        values = self._tables.values
        if key not in values:
            values[key] = make()
        return values[key]

    def column_tables(self, fft: SlabFFT) -> tuple[np.ndarray, np.ndarray]:
        """Return q_y (1/a) and multiplicity of every column, (blocks, W); 0 for missing columns."""
        j = fft.edges[:-1, None] + np.arange(fft.W)
        weight = np.where(j < fft.edges[1:, None], self.multiplicity(j), 0)
        q_y = np.where(weight > 0, self.q_y[np.minimum(j, self.n[1] // 2)], 0.0)
        return q_y.astype(fft.dtype), weight.astype(fft.dtype)


class _Kept(threading.local):
    """Tables of the grids that a thread has used last: threads never share scratch memory."""

    def __init__(self) -> None:
        self.tables = lru_cache(maxsize=KEPT)(lambda *size: GridTables())


_kept = _Kept()
