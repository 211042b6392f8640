"""The one decorator of all kernels."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numba.core.registry import CPUDispatcher

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
        different copies of it, and results could differ in the last bits. It has no entry for
        Python, which can call its source, `py_func`.
    part : bool
        Set for a large part of one other kernel: its source is copied into that one before anything
        is compiled, which takes half as long as compiling both.

    Returns
    -------
    function
        Called as the one that was given. A piece raises TypeError when Python calls it.
    """
    compiled = compiled_on_first_use(
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
    if piece:
        compiled.__class__ = Piece
    return compiled


class Piece(CPUDispatcher):
    """A piece of other kernels, which has no entry for Python."""

    def __call__(self, *_: Any, **__: Any) -> Any:
        """Raise TypeError: without an entry, numba's own call would end the process."""
        name = self.py_func.__name__
        raise TypeError(f"{name} is a piece of kernels; Python can call {name}.py_func")


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
