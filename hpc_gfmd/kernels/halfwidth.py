"""Numbers of 16 bits (bfloat16: the first half of a float32), for what may be wrong by 1/128 of itself.

Kernels are given arrays of uint16. Cut off, not rounded: nothing becomes larger than it was.
"""

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from .jit import inline

INFINITE = np.uint16(0xFF80)  # minus infinity


def _same_bits(of, to, kind):
    """A function of kernels: the bits of a number of 32 bits as one of another type."""

    @intrinsic
    def cast(_, number):
        return to(of), lambda context, builder, signature, values: builder.bitcast(values[0], kind)

    return cast


_bits = _same_bits(types.float32, types.uint32, ir.IntType(32))
_number = _same_bits(types.uint32, types.float32, ir.FloatType())


@inline
def narrow(number):
    """The 16 bits of a number."""
    return np.uint16(_bits(number) >> np.uint32(16))


@inline
def widen(bits):
    """The float32 that 16 bits stand for."""
    return _number(np.uint32(bits) << np.uint32(16))


class Widened:
    """An array of 16 bits a number as one of float32, made where it is sliced."""

    dtype = np.dtype(np.float32)

    def __init__(self, bits):
        self.bits, self.shape = bits, bits.shape

    def __getitem__(self, place):
        return (self.bits[place].astype(np.uint32) << 16).view(np.float32)

    def __array__(self, dtype=None, copy=None):
        return np.asarray(self[:], dtype)


def narrowed(numbers):
    """An array of numbers in 16 bits each."""
    return (np.asarray(numbers, np.float32).view(np.uint32) >> 16).astype(np.uint16)
