"""Storage of numbers that may be wrong by 1/128 of themselves: of float32 its first 16 bits
(bfloat16), of float64 a float32.

Kernels are given arrays of float32 or of uint16. Sixteen bits are cut off, not rounded: nothing
becomes larger than it was.
"""

import numpy as np
from numba import types
from numba.extending import overload


def stored_dtype(dtype):
    """Return the dtype of lower precision: uint16 (bfloat16) beside float32, float32 beside
    float64.
    """
    return np.dtype(np.uint16 if np.dtype(dtype) == np.float32 else np.float32)


def encode(number):
    """Return a number as it is stored: float32 as uint16, float64 as float32. Only in kernels."""


def decode(number):
    """Return the number that a stored one stands for: the inverse of `encode`. Only in kernels."""


@overload(encode)
def _encode(number):
    """Return what numba compiles for `encode`."""
    if number == types.float32:
        return lambda number: np.uint16(np.float32(number).view(np.uint32) >> np.uint32(16))
    return lambda number: np.float32(number)


@overload(decode)
def _decode(number):
    """Return what numba compiles for `decode`."""
    if number == types.uint16:
        return lambda number: np.uint32(np.uint32(number) << np.uint32(16)).view(np.float32)
    return lambda number: np.float64(number)


class Decoded:
    """View of a stored array, of uint16 or float32, as float32.

    A slice of uint16 is converted to a new array when it is taken; a slice of float32 is a view.
    """

    dtype = np.dtype(np.float32)

    def __init__(self, numbers):
        self.numbers, self.shape = numbers, numbers.shape

    def __getitem__(self, place):
        part = self.numbers[place]
        return part if part.dtype == self.dtype else (part.astype(np.uint32) << 16).view(self.dtype)

    def __array__(self, dtype=None, copy=None):
        return np.array(self[:], dtype)


def encoded(numbers, dtype):
    """Convert numbers to the lower precision in which they are stored beside fields of `dtype`; may
    return `numbers` itself.
    """
    numbers = np.asarray(numbers, np.float32)
    if stored_dtype(dtype) == np.float32:
        return numbers
    return (numbers.view(np.uint32) >> 16).astype(np.uint16)
