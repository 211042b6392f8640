"""Kernel of the exact selection of the n-th smallest number of a field (operators/selection.py)."""

import numpy as np

from .jit import kernel

DIGIT = 16  # bits that one pass over the field decides


@kernel
def count_digits(bits, inside, sign, shift, prefix, counts):
    """Add to `counts` the values of the next digit, above `shift` bits, of keys with a known
    prefix: bits with the sign bit set if positive, else inverted.
    """
    every = sign | (sign - np.uint64(1))
    mask = np.uint64((1 << DIGIT) - 1)
    width = np.uint64(DIGIT)
    for i in range(inside[0]):
        for j in range(inside[1]):
            b = np.uint64(bits[i, j])
            key = every & ~b if b & sign else b | sign
            digits = key >> shift
            if digits >> width == prefix:
                counts[digits & mask] += 1.0


@kernel
def depths_below(field, inside, level):
    """Return the sums of max(-height, 0) and of max(level - height, 0) over points `inside`."""
    below_zero = below_level = 0.0
    for i in range(inside[0]):
        for j in range(inside[1]):
            height = 1.0 * field[i, j]
            below_zero += max(-height, 0.0)
            below_level += max(level - height, 0.0)
    return below_zero, below_level
