"""Kernels on spectra. A spectrum is stored in blocks of W columns (see parallel/fft.py); |q| is computed on the fly."""

import numpy as np

from .jit import kernel


@kernel
def to_blocks(rows, blocks, i0, count):
    """Copy `count` transformed rows, shape (R, n_c), to rows i0.. of the blocks, shape (M, n_loc, W)."""
    M, _, W = blocks.shape
    n_c = rows.shape[1]
    for m in range(M):
        width = min(W, n_c - m * W)
        for r in range(count):
            for w in range(width):
                blocks[m, i0 + r, w] = rows[r, m * W + w]


@kernel
def from_blocks(blocks, rows, i0, count):
    """The inverse of `to_blocks`."""
    M, _, W = blocks.shape
    n_c = rows.shape[1]
    for m in range(M):
        width = min(W, n_c - m * W)
        for r in range(count):
            for w in range(width):
                rows[r, m * W + w] = blocks[m, i0 + r, w]


@kernel
def multiply_stiffness(block, q_x, q_y, weight, factor):
    """block *= factor |q|, in place; returns sum(weight factor |q| |block|^2) of the values before.

    block: (n_x, 2 W) real and imaginary parts; q_x: (n_x,); q_y, weight: (2 W,), every column twice: weight is the multiplicity of
    a column in the half spectrum, 0 for padding.
    """
    n_x, W = block.shape
    energy = 0.0
    for i in range(n_x):
        qx2 = q_x[i] * q_x[i]
        row = block[i]
        e = q_y.dtype.type(0)
        for w in range(W):
            k = factor * np.sqrt(qx2 + q_y[w] * q_y[w])
            c = row[w]
            e += weight[w] * k * c * c
            row[w] = k * c
        energy += e
    return energy


@kernel
def multiply_compliance(block, q_x, q_y, weight, factor):
    """block *= factor/|q|, in place, and 0 at q = 0; returns sum(weight factor/|q| |block|^2) of the values before."""
    n_x, W = block.shape
    energy = 0.0
    zero = q_y.dtype.type(0)
    for i in range(n_x):
        qx2 = q_x[i] * q_x[i]
        row = block[i]
        e = zero
        for w in range(W):
            q2 = qx2 + q_y[w] * q_y[w]
            s = factor / np.sqrt(q2) if q2 > zero else zero
            c = row[w]
            e += weight[w] * s * c * c
            row[w] = s * c
        energy += e
    return energy


@kernel
def spectrum_sums(block, q_x, q_y, weight):
    """sum(weight |block|^2) and sum(weight q^2 |block|^2), both without q = 0."""
    n_x, W = block.shape
    s0 = 0.0
    s2 = 0.0
    for i in range(n_x):
        qx2 = q_x[i] * q_x[i]
        for w in range(W):
            q2 = qx2 + q_y[w] * q_y[w]
            if q2 > 0.0:
                c = block[i, w]
                e = weight[w] * (np.float64(c.real) * c.real + np.float64(c.imag) * c.imag)
                s0 += e
                s2 += q2 * e
    return s0, s2
