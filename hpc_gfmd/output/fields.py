"""Fields of a contact: computed when read, or in memory like stored fields."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

FIELDS = ("pressure", "gap", "displacement", "plastic", "dent")


@dataclass(frozen=True, eq=False)
class LazyField:
    """A field on this rank whose rows(i0, i1) are computed, on several threads, when it is sliced
    (without a step); nothing is kept.
    """

    rows: Callable[[int, int], np.ndarray]
    shape: tuple[int, int]
    dtype: np.dtype
    by_rows: Callable[[Callable[[int, int], None], int], Any]

    def __getitem__(self, rows: slice) -> np.ndarray:
        """Compute the local rows of a slice and return them as a new array; a step is ignored."""
        i0, i1, _ = rows.indices(self.shape[0])
        out = np.empty((max(i1 - i0, 0), self.shape[1]), self.dtype)

        def fill(i: int, j: int) -> None:
            out[i:j] = self.rows(i0 + i, i0 + j)

        self.by_rows(fill, len(out))
        return out

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        """Compute all local rows and return them as a new array, whatever `copy` is."""
        return np.asarray(self[:], dtype=dtype)


@dataclass(frozen=True)
class Slab:
    """This rank's rows of a field in memory, with the methods of `Stored`, a field in a file."""

    data: Any
    start: int
    shape: tuple[int, int]

    @property
    def dtype(self) -> np.dtype:
        """Type of the values."""
        return np.dtype(self.data.dtype)

    def read(self, start: int | None = None, stop: int | None = None) -> np.ndarray:
        """Return some rows of this rank, by their global indices; default: all. May be a view."""
        i0, i1 = (None if i is None else i - self.start for i in (start, stop))
        return np.ascontiguousarray(self.data[i0:i1])
