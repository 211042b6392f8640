"""Kernels on spectra: the columns of a block, transposed to be transformed.

Letters, in the program's units (lengths a, gaps g_rms a, pressures E* g_rms).

========  ==========================================================================================
w         column of a block, of W; k: block of this rank
columns   (W, 2 n_x) real and imaginary parts in turn, of K d, u or p
q_x, q_y  wave numbers, in 1/a
K         stiffness, in 1/a: |q|/2, computed on the fly, or from a table, which is even in q_x:
          (blocks, W, n_x//2 + 1)
scale     1/N of the transforms
weight    (blocks, W): how often a column of the half spectrum occurs in the full one, 0 for padding
========  ==========================================================================================
"""

import numpy as np

from .atomic import add
from .jit import inline, kernel
from .transforms import load_columns, store_columns

PIECE = 1024  # numbers that are summed up in their own precision


@kernel
def multiply_blocks(columns, shares, turns, numbers, factors, inverse, backward, sums):
    """Transform blocks of columns, multiply them by K or 1/K, and transform back, in place.

    Threads, with column transforms of their own, take shares by `turns`. numbers: scratch as real
    numbers; factors: (scale, weight, q_x, q_y, table). `sums` (blocks, 2): of `multiply`, and the
    first real number before (rank 0, block 0: q = 0). Without `backward` only `sums` counts.
    """
    plans = columns[5]
    scale, weight, q_x, q_y, table = factors
    share = add(turns, 0, 1)
    while share < shares.shape[0]:
        for k in range(shares[share, 0], shares[share, 1]):
            if plans[k, 0] > 0:
                load_columns(columns, k)
                sums[k, 1] = numbers[0, 0]
                sums[k, 0] = multiply(
                    numbers[: plans[k, 0]], k, inverse, scale, weight, q_x, q_y, table
                )
                if backward:
                    store_columns(columns, k)
        share = add(turns, 0, 1)


@inline
def multiply(columns, k, inverse, scale, weight, q_x, q_y, table):
    """Multiply block k by scale K or scale/K (0 where K is 0), in place; return the sum of weight
    scale K |c|^2 (or |c|^2/K) before. q_x: every wave number twice.
    """
    energy = 0.0
    for w in range(columns.shape[0]):
        if table is None:
            energy += weight[k, w] * _multiply_by_q(columns[w], q_x, q_y[k, w], scale, inverse)
        else:
            energy += weight[k, w] * _multiply_by_table(columns[w], table[k, w], scale, inverse)
    return energy


@inline
def _multiply_by_q(column, q_x, q_y, scale, inverse):
    """Multiply one column by scale K or scale/K, K = |q|/2; return its energy, unweighted, PIECE
    numbers at a time in their own precision.
    """
    real = column.dtype.type
    qy2 = q_y * q_y
    zero = real(0)
    factor = scale * real(2 if inverse else 0.5)
    energy = 0.0
    for i in range(0, column.shape[0], PIECE):
        piece = column[i : i + PIECE]
        q = q_x[i : i + PIECE]
        part = zero
        if inverse:
            for j in range(piece.shape[0]):
                q2 = q[j] * q[j] + qy2
                scaled = factor / np.sqrt(q2) if q2 > zero else zero
                value = piece[j]
                part += scaled * value * value
                piece[j] = scaled * value
        else:
            for j in range(piece.shape[0]):
                scaled = factor * np.sqrt(q[j] * q[j] + qy2)
                value = piece[j]
                part += scaled * value * value
                piece[j] = scaled * value
        energy += part
    return energy


@inline
def _multiply_by_table(column, table, scale, inverse):
    """Do the same with K from a table, at q_x >= 0 and this column's q_y."""
    n_x = column.shape[0] // 2
    stored = table.shape[0]
    zero = column.dtype.type(0)
    energy = 0.0
    for i0 in range(0, n_x, PIECE):
        part = zero
        for i in range(i0, min(i0 + PIECE, n_x)):
            K = table[i if i < stored else n_x - i]
            scaled = (scale / K if K > zero else zero) if inverse else scale * K
            re = column[2 * i]
            im = column[2 * i + 1]
            part += scaled * (re * re + im * im)
            column[2 * i] = scaled * re
            column[2 * i + 1] = scaled * im
        energy += part
    return energy


@kernel
def spectrum_sums(columns, q_x, q_y, weight):
    """Return the sums of weight |columns|^2 times 1, q^2 and q^4, without q = 0."""
    power = 0.0
    slopes = 0.0
    curvatures = 0.0
    for w in range(columns.shape[0]):
        qy2 = q_y[w] * q_y[w]
        for i in range(columns.shape[1]):
            q2 = q_x[i] * q_x[i] + qy2
            if q2 > 0.0:
                c = columns[w, i]
                square = weight[w] * (np.float64(c.real) * c.real + np.float64(c.imag) * c.imag)
                power += square
                slopes += q2 * square
                curvatures += q2 * q2 * square
    return power, slopes, curvatures
