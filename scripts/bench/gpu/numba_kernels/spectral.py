"""Multiplication of a spectrum by K = |q|/2, and transposition of its columns.

Letters as in hpc_gfmd/kernels/spectral.py.
"""

import math

import numpy as np
from numba import cuda

from .launch import STRIP, THREADS, ZERO, blocks_of, launch, partial_sums, sum_of_block

TILE = 32  # rows and columns that a block transposes
PITCH = TILE + 1  # numbers of a row of a tile in shared memory: columns then lie in all banks
TILE_ROWS = 8  # of the threads of such a block


def multiply(block, q_0, q_1, weight_0, weight_1, scale):
    """Multiply complex numbers by scale K, in place.

    Parameters
    ----------
    block : (rows, columns) complex64
        A part of a spectrum, or its transpose.
    q_0, q_1 : (rows,), (columns,) float32
        Wave numbers along both axes.
    weight_0, weight_1 : (rows,), (columns,) float32
        The product is how often a number of the half spectrum occurs in the full one.
    scale : float
        1/N of the transforms.

    Returns
    -------
    array (blocks, 1) float64
        On the device: the sum of weight scale K |c|^2 over the complex numbers c before they were
        multiplied, in parts.
    """
    blocks = blocks_of(*block.shape)
    partial = partial_sums(block, blocks, 1)
    factor = np.float32(scale * 0.5)
    arguments = (block, q_0, q_1, weight_0, weight_1, factor, partial)
    launch(multiply_block, blocks, THREADS, *arguments)
    return partial


def transpose(source, target):
    """Set target to the transpose of source, both (rows, columns) complex64, perhaps parts."""
    rows, columns = source.shape
    blocks = -(-columns // TILE), -(-rows // TILE)
    launch(transpose_tiles, blocks, (TILE, TILE_ROWS), source, target)


@cuda.jit
def multiply_block(block, q_0, q_1, weight_0, weight_1, factor, partial):
    """Multiply complex numbers, as `multiply` describes."""
    shared = cuda.shared.array(THREADS, np.float64)
    j = cuda.blockIdx.x * THREADS + cuda.threadIdx.x
    start = cuda.blockIdx.y * STRIP
    end = min(start + STRIP, block.shape[0])
    energy = ZERO
    if j < block.shape[1]:
        square_1 = q_1[j] * q_1[j]
        for i in range(start, end):
            q2 = q_0[i] * q_0[i] + square_1
            scaled = factor * math.sqrt(q2)
            number = block[i, j]
            re = number.real
            im = number.imag
            energy += weight_0[i] * scaled * (re * re + im * im)
            block[i, j] = np.complex64(complex(scaled * re, scaled * im))
        energy *= weight_1[j]
    sum_of_block(energy, shared, partial, 0)


@cuda.jit
def transpose_tiles(source, target):
    """Transpose, as `transpose` describes; every block one tile."""
    tile = cuda.shared.array((TILE, PITCH), np.complex64)
    x = cuda.threadIdx.x
    i0 = cuda.blockIdx.y * TILE
    j0 = cuda.blockIdx.x * TILE
    for y in range(cuda.threadIdx.y, TILE, TILE_ROWS):
        if i0 + y < source.shape[0] and j0 + x < source.shape[1]:
            tile[y, x] = source[i0 + y, j0 + x]
    cuda.syncthreads()
    for y in range(cuda.threadIdx.y, TILE, TILE_ROWS):
        if i0 + x < source.shape[0] and j0 + y < source.shape[1]:
            target[j0 + y, i0 + x] = tile[x, y]
