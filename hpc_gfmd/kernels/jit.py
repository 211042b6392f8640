"""The one decorator of all kernels."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from .cache import compiled_on_first_use

# NaN and infinity must stay visible, so no "nnan" and "ninf"; "reassoc" is what lets a sum use the
# vector unit.
FASTMATH = {"reassoc", "contract", "nsz", "arcp"}


def kernel(function: Callable[..., Any], piece: bool = False, part: bool = False) -> Any:
    """Make a function a kernel: compiled on first use, kept in the cache, run without the GIL.

    Parameters
    ----------
    function : function
        Of arrays and numbers. It must not make arrays: counting references, also of every row that
        a loop takes, would be slow.
    piece : bool
        Set for a small piece of other kernels: its machine code is copied into theirs. If it were
        called instead, code from the cache and code that has just been compiled would contain
        different copies of it, and results could differ in the last bits. Python must not
        call it: there is no entry for Python, and the process would end.
    part : bool
        Set for a large part of one other kernel: its source is copied into that one before anything
        is compiled, which takes half as long as compiling both.

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
    """Return how many points of row i belong to the surface: the first ones of the row.

    The number is unsigned: a loop that begins at a number that might be negative, counted from the
    end, does not use vectors.

    Parameters
    ----------
    i : int
        Local row.
    inside : (int, int)
        Rows and points of this rank's part of the surface.

    Returns
    -------
    np.uint64
        0 in a row beyond the surface.
    """
    return np.uint64(inside[1] if i < inside[0] else 0)
