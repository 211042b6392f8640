"""The one decorator of all kernels."""

import numba

# NaN and infinity must stay visible, so no "nnan" and "ninf"; "reassoc" is what lets a sum use the vector unit.
FASTMATH = {"reassoc", "contract", "nsz", "arcp"}


def kernel(function):
    """Compile on first use, keep in the cache, release the GIL."""
    return numba.njit(cache=True, nogil=True, error_model="numpy", fastmath=FASTMATH)(function)


def inline(function):
    """A piece of a kernel; LLVM inlines it where it is used."""
    return numba.njit(cache=True, nogil=True, error_model="numpy", fastmath=FASTMATH)(function)
