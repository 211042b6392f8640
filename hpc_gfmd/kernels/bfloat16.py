"""Storage of numbers that may be wrong by 1/128: the first 16 bits of float32 (bfloat16, as
uint16), float32 of float64. Bits are cut off: nothing becomes larger.
"""

import numpy as np
from numba import types
from numba.extending import overload


def stored_dtype(dtype):
    """Return the lower precision: uint16 (bfloat16) beside float32, float32 beside float64."""
    return np.dtype(np.uint16 if np.dtype(dtype) == np.float32 else np.float32)


def encode(number):
    """Return a number as it is stored: float32 as uint16, float64 as float32. Only in kernels."""


def decode(number):
    """Return the number that a stored one stands for: the inverse of `encode`. Only in kernels."""


@overload(encode)
def _encode(number):
    if number == types.float32:
        return lambda number: np.uint16(np.float32(number).view(np.uint32) >> np.uint32(16))
    return lambda number: np.float32(number)


@overload(decode)
def _decode(number):
    if number == types.uint16:
        return lambda number: np.uint32(np.uint32(number) << np.uint32(16)).view(np.float32)
    return lambda number: np.float64(number)


class Decoded:
    """View of a stored array as float32; a slice of uint16 is converted anew, of float32 a view."""

    dtype = np.dtype(np.float32)

    def __init__(self, numbers):
        self.numbers, self.shape = numbers, numbers.shape

    def __getitem__(self, place):
        part = self.numbers[place]
        return part if part.dtype == self.dtype else (part.astype(np.uint32) << 16).view(self.dtype)

    def __array__(self, dtype=None, copy=None):
        return np.array(self[:], dtype)


def encoded(numbers, dtype):
    """Convert numbers to the lower precision beside `dtype`; may return `numbers` itself."""
    numbers = np.asarray(numbers, np.float32)
    if stored_dtype(dtype) == np.float32:
        return numbers
    return (numbers.view(np.uint32) >> 16).astype(np.uint16)
