"""The one decorator of all kernels."""

import numba

from .cache import cache_of

# NaN and infinity must stay visible, so no "nnan" and "ninf"; "reassoc" is what lets a sum use the vector unit.
FASTMATH = {"reassoc", "contract", "nsz", "arcp"}


def kernel(function):
    """Compile on first use, keep in the cache, release the GIL."""
    compiled = numba.njit(nogil=True, error_model="numpy", fastmath=FASTMATH)(function)
    compiled._cache = cache_of(function)  # what cache=True does, with a cache that may be damaged
    return compiled


inline = kernel  # a piece of a kernel; LLVM inlines it where it is used
