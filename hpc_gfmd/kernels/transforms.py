"""One-dimensional transforms in kernels, and where rows and columns of a field stand before and
after them (parallel/fft.py).

A transform is called by the address of a C function of a plan, a source and a target. What kernels
take of a thread:

    rows       (real, half, blocks, edges, n_loc, forward, backward): scratch of a pass, real
               (R, n_y) and complex (R, n_c); the spectra of the n_loc rows of this rank, in blocks
               of columns that stand one after another; first column of each block, and n_c;
               (function, plan) of the transforms
    columns    (moved, near, far, function, plans): scratch of a block (W, n_x) in a type that the
               compiler moves at once; what of the blocks stands in memory that ranks have in
               common, and what other nodes have sent; the transforms

near and far are (memory, first, rows): rows[r, 0] <= i < rows[r, 1] of block k stand at
memory[first[k, r]:]. plans[k] is (width, columns of the plan, forward, backward).
"""

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from .jit import inline, kernel
from .lines import WIDTH, move_line

TILE = 8  # complex numbers of single precision in a cache line


@intrinsic
def transform(_, function, plan, source, target):
    """Call the C function at an address with a plan and the memory of two arrays, in kernels."""

    def generate(context, builder, signature, values):
        pointer = ir.IntType(8).as_pointer()
        memory = [
            context.make_array(signature.args[k])(context, builder, values[k]).data for k in (2, 3)
        ]
        called = ir.FunctionType(ir.VoidType(), [pointer] * 3).as_pointer()
        builder.call(
            builder.inttoptr(values[0], called),
            [
                builder.inttoptr(values[1], pointer),
                *(builder.bitcast(address, pointer) for address in memory),
            ],
        )
        return context.get_dummy_value()

    return types.void(function, plan, source, target), generate


@kernel
def store_rows(rows, i0, i1):
    """Transform the real rows i0..i1 of a pass and copy their spectra to the blocks."""
    real, half, blocks, edges, n_loc, (function, plan), _ = rows
    transform(function, plan, real, half)
    to_blocks(half, blocks, edges, n_loc, i0, i1 - i0)


@kernel
def load_rows(rows, i0, i1):
    """Copy the spectra of rows i0..i1 from the blocks and transform them to real rows of a pass."""
    real, half, blocks, edges, n_loc, _, (function, plan) = rows
    from_blocks(blocks, half, edges, n_loc, i0, i1 - i0)
    transform(function, plan, half, real)


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
def load_columns(columns, k, forward):
    """Fill the scratch with the columns of block k and transform them; forward=False: with 0."""
    moved, near, far, function, plans = columns
    width, planned = plans[k, 0], plans[k, 1]
    moved[width if forward else 0 : planned] = 0
    if forward:
        for memory, first, rows in (near, far):
            _transpose(memory, first[k], rows, moved[:width])
        transform(function, plans[k, 2], moved, moved)


@kernel
def store_columns(columns, k):
    """Transform the scratch back and put it where the columns of block k stand."""
    moved, near, far, function, plans = columns
    transform(function, plans[k, 3], moved, moved)
    for memory, first, rows in (near, far):
        _transpose_back(moved[: plans[k, 0]], memory, first[k], rows)


@inline
def _transpose(memory, first, rows, columns):
    """Set columns (W, n_x) = a block (n_x, W) transposed, a cache line of either at a time."""
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


@inline
def _transpose_back(columns, memory, first, rows):
    """Undo `_transpose`."""
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
