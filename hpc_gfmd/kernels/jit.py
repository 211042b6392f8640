"""The one decorator of all kernels."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from .cache import compiled_on_first_use

# NaN and infinity must stay visible, so no "nnan" and "ninf"; "reassoc" is what lets a sum use the
# vector unit.
FASTMATH = {"reassoc", "contract", "nsz", "arcp"}


def kernel(function: Callable[..., Any], makes_arrays: bool = False, piece: bool = False) -> Any:
    """Compile on first use, keep in the cache, release the GIL.

    makes_arrays: or returns some. Only then references to arrays are counted, to every row that a
    loop takes, which is slow. piece: of another kernel. As a function of its own, kept code would
    have another copy of it than code that has just been compiled, and other last bits.
    """
    return compiled_on_first_use(
        function,
        nogil=True,
        error_model="numpy",
        fastmath=FASTMATH,
        _nrt=makes_arrays,
        forceinline=piece,
    )


inline = partial(kernel, piece=True)
making_arrays = partial(kernel, makes_arrays=True)


@inline
def points_inside(i: int, inside: tuple[int, int]) -> np.uint64:
    """Return how many points of row i belong to the surface, where `inside` is the shape of a
    slab's part of it.

    Without a sign: a loop that begins at a number that might be negative, counted from the end,
    does not use vectors.
    """
    return np.uint64(inside[1] if i < inside[0] else 0)
