"""Fields of a surface as results have them: rows that are computed when they are asked for."""

from collections.abc import Callable

import numpy as np

from ..output.fields import LazyField
from ..surface import Surface
from ..surface.number_range import field_dtype


def heights_of(surface: Surface) -> LazyField:
    """Return the heights of a surface as a local slab: scene's unit, peaks up, the highest at 0.

    They are computed from `surface.h`, which must not be None, when the slab is sliced.
    """
    h = surface.h
    assert h is not None  # asked for before a sweep in low memory gives them away
    dtype = field_dtype("heights", h.dtype, 0.0, surface)
    return field_of_surface(
        surface, lambda i0, i1: h[i0:i1] * -dtype.type(surface.height_unit), dtype
    )


def field_of_surface(
    surface: Surface, values: Callable[[int, int], np.ndarray], dtype: np.dtype
) -> LazyField:
    """Return a field of this rank's rows of the surface, computed when it is sliced.

    `values(i0, i1)` returns rows of the solver's arrays, cut to the points of the surface, in units
    of the result, on several threads. If an axis was left out because nothing varies along it
    (`Surface.reduced_axis`), they are repeated along it.
    """
    left_out = surface.reduced_axis

    def rows(i0: int, i1: int) -> np.ndarray:
        # with the second axis left out every rank has all rows
        start = surface.rows[0] if left_out == 1 else 0
        of_arrays = values(0, 1) if left_out == 0 else values(start + i0, start + i1)
        if left_out is None:
            return of_arrays
        return np.broadcast_to(of_arrays, (i1 - i0, surface.n[1]))

    shape = surface.rows[1] - surface.rows[0], surface.n[1]
    return LazyField(rows, shape, dtype, surface.grid.by_rows)
