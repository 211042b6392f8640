"""Kernel of the exact selection of the n-th smallest number of a field (operators/selection.py)."""

import numpy as np

from .jit import kernel

DIGIT = 16  # bits that one pass over the field decides


@kernel
def count_digits(bits, inside, sign, shift, prefix, counts):
    """Count the values of the next digit among all numbers whose key begins with a known prefix.

    The key of a floating-point number orders as its value does: its bits with the sign bit set
    where the number is positive, and all bits inverted where it is negative.

    Parameters
    ----------
    bits : array of uint32 or uint64, rows of a local slab
        The bits of floating-point numbers.
    inside : tuple of int
        Rows and points of each row that count.
    sign : uint64
        The sign bit.
    shift : uint64
        Number of bits below the digit.
    prefix : uint64
        The bits of the key above the digit.
    counts : array of float64, (2**DIGIT,)
        Is increased by the number of such keys, for each value of the digit.
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
    """Sum up how far points lie below 0, and how far below a level.

    Parameters
    ----------
    field : array, rows of a local slab
        Heights.
    inside : tuple of int
        Rows and points of each row that count.
    level : float
        A height.

    Returns
    -------
    below_zero, below_level : float64
        Sums of max(-height, 0) and of max(level - height, 0).
    """
    below_zero = below_level = 0.0
    for i in range(inside[0]):
        for j in range(inside[1]):
            height = 1.0 * field[i, j]
            below_zero += max(-height, 0.0)
            below_level += max(level - height, 0.0)
    return below_zero, below_level
