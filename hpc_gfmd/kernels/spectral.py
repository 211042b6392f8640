"""Kernels on spectra: blocks of W columns as rows of the transform leave them, (n_x, W), and
transposed, (W, n_x), to be transformed.

|q| is computed on the fly, other stiffnesses stand in tables that are even in q_x: (W, n_x//2 + 1).
"""

import numpy as np

from .jit import inline, kernel
from .lines import WIDTH, move_line

TILE = 8  # complex numbers of single precision in a cache line
PIECE = 1024  # numbers that are summed up in their own precision


@kernel
def to_blocks(rows, blocks, edges, n_loc, i0, count):
    """Copy `count` transformed rows, shape (R, n_c), to rows i0.. of n_loc of the blocks, which lie
    one after another; edges: first column of each of them, and n_c."""
    source, target = rows.view(np.float64), blocks.view(np.float64)
    n = source.shape[1]
    words = n // rows.shape[1]
    flat = source.reshape(source.size)
    for m in range(edges.shape[0] - 1):
        j0, width = words * edges[m], words * (edges[m + 1] - edges[m])
        start = words * n_loc * edges[m] + i0 * width
        for r in range(count):
            a, b = start + r * width, r * n + j0
            for w in range(0, width - width % WIDTH, WIDTH):
                move_line(target, a + w, flat, b + w)
            for w in range(width - width % WIDTH, width):
                target[a + w] = flat[b + w]


@kernel
def from_blocks(blocks, rows, edges, n_loc, i0, count):
    """Undo `to_blocks`."""
    source, target = blocks.view(np.float64), rows.view(np.float64)
    n = target.shape[1]
    words = n // rows.shape[1]
    flat = target.reshape(target.size)
    for m in range(edges.shape[0] - 1):
        j0, width = words * edges[m], words * (edges[m + 1] - edges[m])
        start = words * n_loc * edges[m] + i0 * width
        for r in range(count):
            a, b = start + r * width, r * n + j0
            for w in range(0, width - width % WIDTH, WIDTH):
                move_line(flat, b + w, source, a + w)
            for w in range(width - width % WIDTH, width):
                flat[b + w] = source[a + w]


@kernel
def transpose(memory, first, rows, columns):
    """Set columns (W, n_x) = a block (n_x, W) transposed, a cache line of either at a time. The
    block is in pieces: its rows rows[k, 0] <= i < rows[k, 1] stand at memory[first[k]:]."""
    W = columns.shape[0]
    for k in range(first.shape[0]):
        i0, n = rows[k, 0], rows[k, 1] - rows[k, 0]
        block = memory[first[k] : first[k] + n * W].reshape(n, W)
        whole = n - n % TILE
        for i in range(0, whole, TILE):
            for w in range(W):
                for j in range(TILE):
                    columns[w, i0 + i + j] = block[i + j, w]
        for i in range(whole, n):
            for w in range(W):
                columns[w, i0 + i] = block[i, w]


@kernel
def transpose_back(columns, memory, first, rows):
    """Undo `transpose`."""
    W = columns.shape[0]
    for k in range(first.shape[0]):
        i0, n = rows[k, 0], rows[k, 1] - rows[k, 0]
        block = memory[first[k] : first[k] + n * W].reshape(n, W)
        whole = n - n % TILE
        for i in range(0, whole, TILE):
            for w in range(W):
                for j in range(TILE):
                    block[i + j, w] = columns[w, i0 + i + j]
        for i in range(whole, n):
            for w in range(W):
                block[i, w] = columns[w, i0 + i]


@kernel
def multiply_stiffness(columns, q_x, q_y, weight, factor):
    """Multiply columns by factor |q|, in place; returns sum(weight factor |q| |columns|^2) of the
    values before.

    columns: (W, 2 n_x), real and imaginary parts in turn; q_x: (2 n_x,), every number twice; q_y,
    weight: (W,), weight is the multiplicity of a column in the half spectrum, 0 for padding.
    """
    W, n = columns.shape
    energy = 0.0
    for w in range(W):
        qy2 = q_y[w] * q_y[w]
        for i in range(0, n, PIECE):
            piece, q = columns[w, i : i + PIECE], q_x[i : i + PIECE]
            e = q_y.dtype.type(0)
            for j in range(piece.shape[0]):
                k = factor * np.sqrt(q[j] * q[j] + qy2)
                c = piece[j]
                e += k * c * c
                piece[j] = k * c
            energy += weight[w] * e
    return energy


@kernel
def multiply_compliance(columns, q_x, q_y, weight, factor):
    """Multiply columns by factor/|q|, by 0 at q = 0, in place; returns sum(weight factor/|q|
    |columns|^2) of the values before."""
    W, n = columns.shape
    energy = 0.0
    zero = q_y.dtype.type(0)
    for w in range(W):
        qy2 = q_y[w] * q_y[w]
        for i in range(0, n, PIECE):
            piece, q = columns[w, i : i + PIECE], q_x[i : i + PIECE]
            e = zero
            for j in range(piece.shape[0]):
                q2 = q[j] * q[j] + qy2
                s = factor / np.sqrt(q2) if q2 > zero else zero
                c = piece[j]
                e += s * c * c
                piece[j] = s * c
            energy += weight[w] * e
    return energy


@kernel
def multiply_by_table(columns, table, weight, factor):
    """Multiply columns by factor table, in place; returns sum(weight factor table |columns|^2) of
    the values before.

    columns: (W, 2 n_x), real and imaginary parts in turn; table: (W, n_x//2 + 1) for q_x = 0 and
    the positive ones; weight: (W,).
    """
    energy = 0.0
    for w in range(columns.shape[0]):
        energy += weight[w] * _multiply(columns[w], table[w], factor, False)
    return energy


@kernel
def divide_by_table(columns, table, weight, factor):
    """Multiply columns by factor/table, by 0 where the table is 0; returns sum(weight factor/table
    |columns|^2) of the values before."""
    energy = 0.0
    for w in range(columns.shape[0]):
        energy += weight[w] * _multiply(columns[w], table[w], factor, True)
    return energy


@inline
def _multiply(column, table, factor, divide):
    """Multiply one column; the energy is summed up over PIECE numbers in their own precision."""
    n, half = column.shape[0] // 2, table.shape[0]
    zero = factor * 0
    energy = 0.0
    for i0 in range(0, n, PIECE):
        e = zero
        for i in range(i0, min(i0 + PIECE, n)):
            t = table[i if i < half else n - i]
            k = (factor / t if t > zero else zero) if divide else factor * t
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
