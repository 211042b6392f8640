"""The one decorator of all kernels."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from .cache import compiled_on_first_use

# NaN and infinity must stay visible, so no "nnan" and "ninf"; "reassoc" is what lets a sum use the
# vector unit.
FASTMATH = {"reassoc", "contract", "nsz", "arcp"}


def kernel(
    function: Callable[..., Any],
    piece: bool = False,
    part: bool = False,
) -> Any:
    """Compile a function on first use, keep it in the cache, release the GIL while it runs.

    Parameters
    ----------
    function : function
        Of arrays and numbers. It must not make arrays: counting references, also of every row that
        a loop takes, would be slow.
    piece : bool
        Of other kernels, small: its machine code is copied into theirs. As a function of its own,
        kept code would have another copy of it than code that has just been compiled, and other
        last bits. Python must not call it: there is nothing to call, and the process ends.
    part : bool
        Of one other kernel, large: its source is copied into that one before anything is compiled,
        which takes half as long as compiling both.

    Returns
    -------
    function
        Called as the one that was given.
    """
    return compiled_on_first_use(
        function,
        nogil=True,
        error_model="numpy",
        fastmath=FASTMATH,
        _nrt=False,
        forceinline=piece,
        inline="always" if part else "never",
        no_cpython_wrapper=piece,
        no_cfunc_wrapper=True,
    )


inline = partial(kernel, piece=True)
part = partial(kernel, part=True)


@inline
def points_inside(i: int, inside: tuple[int, int]) -> np.uint64:
    """Return how many points of row i belong to the surface.

    Without a sign: a loop that begins at a number that might be negative, counted from the end,
    does not use vectors.

    Parameters
    ----------
    i : int
        Local row.
    inside : (int, int)
        Rows and points of this rank's part of the surface.

    Returns
    -------
    np.uint64
        From the first point on.
    """
    return np.uint64(inside[1] if i < inside[0] else 0)
