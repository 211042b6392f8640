"""Storage of numbers that may be wrong by 1/128 of themselves: of float32 its first 16 bits
(bfloat16), of float64 a float32.

Kernels are given arrays of float32 or of uint16. Sixteen bits are cut off, not rounded: nothing
becomes larger than it was.
"""

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic, overload

from .jit import inline


def stored_dtype(dtype):
    """Return the dtype of such numbers beside fields of `dtype`."""
    return np.dtype(np.uint16 if np.dtype(dtype) == np.float32 else np.float32)


def _same_bits(of, to, kind):
    """Make a function of kernels that reads the 32 bits of a number as one of another type."""

    @intrinsic
    def cast(_, number):
        return to(of), lambda context, builder, signature, values: builder.bitcast(values[0], kind)

    return cast


_bits = _same_bits(types.float32, types.uint32, ir.IntType(32))
_number = _same_bits(types.uint32, types.float32, ir.FloatType())


def _encode(number):
    """Stand for what `overload` compiles; so does `_decode`."""


def _decode(number):
    pass


@overload(_encode)
def _encode_in_kernels(number):
    if number == types.float32:
        return lambda number: np.uint16(_bits(number) >> np.uint32(16))
    return lambda number: np.float32(number)


@overload(_decode)
def _decode_in_kernels(number):
    if number == types.uint16:
        return lambda number: _number(np.uint32(number) << np.uint32(16))
    return lambda number: np.float64(number)


@inline
def encode(number):
    """Return a number as it is stored."""
    return _encode(number)


@inline
def decode(number):
    """Return the number that a stored one stands for."""
    return _decode(number)


class Decoded:
    """A stored array as one of float32, made where it is sliced."""

    dtype = np.dtype(np.float32)

    def __init__(self, numbers):
        self.numbers, self.shape = numbers, numbers.shape

    def __getitem__(self, place):
        part = self.numbers[place]
        return part if part.dtype == self.dtype else (part.astype(np.uint32) << 16).view(self.dtype)

    def __array__(self, dtype=None, copy=None):
        return np.array(self[:], dtype)


def encoded(numbers, dtype):
    """Return an array of numbers as they are stored beside fields of `dtype`."""
    numbers = np.asarray(numbers, np.float32)
    if stored_dtype(dtype) == np.float32:
        return numbers
    return (numbers.view(np.uint32) >> 16).astype(np.uint16)
