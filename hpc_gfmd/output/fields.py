"""The fields of a contact by name, those that are computed as they are read, and those in memory
that are read as if from a file."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

FIELDS = ("pressure", "gap", "displacement", "plastic")


@dataclass(frozen=True, eq=False)
class LazyField:
    """A local slab that is computed a few rows at a time when it is sliced; np.asarray makes all of
    it.

    Attributes
    ----------
    rows : callable
        Of (i0, i1): the values of these rows.
    shape : (int, int)
        Of the slab.
    dtype : numpy.dtype
    by_rows : callable
        Shares rows among threads, as Grid.by_rows.
    """

    rows: Callable[[int, int], np.ndarray]
    shape: tuple[int, int]
    dtype: np.dtype
    by_rows: Callable[[Callable[[int, int], None], int], Any]

    def __getitem__(self, rows: slice) -> np.ndarray:
        i0, i1, _ = rows.indices(self.shape[0])
        out = np.empty((max(i1 - i0, 0), self.shape[1]), self.dtype)

        def fill(i: int, j: int) -> None:
            out[i:j] = self.rows(i0 + i, i0 + j)

        self.by_rows(fill, len(out))
        return out

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        return np.array(self[:], dtype=dtype)


@dataclass(frozen=True)
class Slab:
    """A field in memory that is read like one of a file.

    Attributes
    ----------
    data : array_like
        The rows of this rank.
    start : int
        Global index of the first of them.
    shape : (int, int)
        (n_x, n_y) of the whole field.
    """

    data: Any
    start: int
    shape: tuple[int, int]

    @property
    def dtype(self) -> np.dtype:
        """Precision of the field."""
        return np.dtype(self.data.dtype)

    def pieces(self) -> Iterator[tuple[int, np.ndarray]]:
        """Yield all of it, as `Stored.pieces` gives a field of a file: (start, rows from
        there on)."""
        yield self.start, self.read()

    def read(self, start: int | None = None, stop: int | None = None) -> np.ndarray:
        """Return some rows of the field.

        Parameters
        ----------
        start, stop : int, optional
            Global indices, which must be among those of this rank; default: all of them.

        Returns
        -------
        ndarray, shape (rows, n_y)
        """
        i0, i1 = (None if i is None else i - self.start for i in (start, stop))
        return np.ascontiguousarray(self.data[i0:i1])
