"""Kernels on spectra: columns (W, n_x) of a block, transposed to be transformed.

|q| is computed on the fly, other stiffnesses stand in tables that are even in q_x: (W, n_x//2 + 1).
"""

import numpy as np

from .jit import inline, kernel
from .transforms import load_columns, store_columns

PIECE = 1024  # numbers that are summed up in their own precision


@kernel
def multiply_blocks(columns, k0, k1, numbers, factors, inverse, backward, found):
    """Transform the blocks k0..k1 of columns, `multiply` them, and transform them back unless
    backward is False. Sets found[k] = what `multiply` returns, and the real part of the first
    number of the block, before.

    columns: see transforms.py; numbers: its scratch as real numbers; factors: (scale, ...) of
    `multiply`.
    """
    plans = columns[5]
    for k in range(k0, k1):
        if plans[k, 0] > 0:
            load_columns(columns, k, True)
            found[k, 1] = numbers[0, 0]
            found[k, 0] = multiply(numbers[: plans[k, 0]], k, inverse, *factors)
            if backward:
                store_columns(columns, k)


@kernel
def multiply(columns, k, inverse, scale, weight, q_x, q_y, table):
    """Multiply the columns of block k of this rank by scale K, or by scale/K, 0 where K is 0, in
    place; returns sum(weight scale K |columns|^2), or with 1/K, of the values before.

    columns: (W, 2 n_x), real and imaginary parts in turn; weight: (blocks, W), multiplicity of a
    column in the half spectrum, 0 for padding; table: (blocks, W, n_x//2 + 1), K of q_x = 0 and the
    positive ones, None where K = |q|/2, with q_x: (2 n_x,), every number twice, and q_y: (blocks,
    W).
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
    """Multiply one column for K = |q|/2; the energy is summed up over PIECE numbers in their own
    precision."""
    real, qy2 = column.dtype.type, q_y * q_y
    zero, factor = real(0), scale * real(2 if inverse else 0.5)
    energy = 0.0
    for i in range(0, column.shape[0], PIECE):
        piece, q = column[i : i + PIECE], q_x[i : i + PIECE]
        e = zero
        if inverse:
            for j in range(piece.shape[0]):
                q2 = q[j] * q[j] + qy2
                k = factor / np.sqrt(q2) if q2 > zero else zero
                c = piece[j]
                e += k * c * c
                piece[j] = k * c
        else:
            for j in range(piece.shape[0]):
                k = factor * np.sqrt(q[j] * q[j] + qy2)
                c = piece[j]
                e += k * c * c
                piece[j] = k * c
        energy += e
    return energy


@inline
def _multiply_by_table(column, table, scale, inverse):
    """Multiply one column for a K that stands in a table; the energy likewise."""
    n, half, zero = column.shape[0] // 2, table.shape[0], column.dtype.type(0)
    energy = 0.0
    for i0 in range(0, n, PIECE):
        e = zero
        for i in range(i0, min(i0 + PIECE, n)):
            t = table[i if i < half else n - i]
            k = (scale / t if t > zero else zero) if inverse else scale * t
            a, b = column[2 * i], column[2 * i + 1]
            e += k * (a * a + b * b)
            column[2 * i] = k * a
            column[2 * i + 1] = k * b
        energy += e
    return energy


@kernel
def spectrum_sums(columns, q_x, q_y, weight):
    """Return sum(weight |columns|^2) and sum(weight q^2 |columns|^2), both without q = 0; columns:
    (W, n_x) complex."""
    W, n_x = columns.shape
    s0 = 0.0
    s2 = 0.0
    for w in range(W):
        qy2 = q_y[w] * q_y[w]
        for i in range(n_x):
            q2 = q_x[i] * q_x[i] + qy2
            if q2 > 0.0:
                c = columns[w, i]
                e = weight[w] * (np.float64(c.real) * c.real + np.float64(c.imag) * c.imag)
                s0 += e
                s2 += q2 * e
    return s0, s2
