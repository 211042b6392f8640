"""The one decorator of all kernels."""

import numba

from .cache import cached

# NaN and infinity must stay visible, so no "nnan" and "ninf"; "reassoc" is what lets a sum use the vector unit.
FASTMATH = {"reassoc", "contract", "nsz", "arcp"}


def kernel(function):
    """Compile on first use, keep in the cache, release the GIL."""
    with cached() as possible:
        return numba.njit(nogil=True, error_model="numpy", fastmath=FASTMATH, cache=possible)(function)


inline = kernel  # a piece of a kernel; LLVM inlines it where it is used
