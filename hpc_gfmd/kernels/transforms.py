"""One-dimensional transforms in kernels, and where rows and columns of a field stand before and
after them (parallel/fft.py).

A transform is called by addresses: (function, plan, source, target), a C function, a plan of it,
and the memory of two arrays. Spectra are moved in words of 8 bytes (float64), of which a complex
number of single precision is one and of double precision two: so the same compiled code moves both.
What kernels take of a thread:

========  ==========================================================================================
rows      (real, spectra)
real      scratch of a pass of rows, (R, n_y), in the precision of the field
spectra   (half, blocks, edges, n_loc, forward, backward)
half      spectra of the rows of a pass, one after the other, in words
blocks    spectra of all n_loc rows of this rank, in blocks of columns that stand one after another,
          in words
edges     first word of each block in a row, and the words of a row
forward   transform of real to half; backward: of half to real
columns   (moved, address, near, far, function, plans)
moved     scratch of a block of columns, (W, n_x), in a type that the compiler moves at once:
          float64 for a complex number of single precision, otherwise the complex number itself;
          address: its memory
near      (memory, begins, rows) of what stands in memory that ranks have in common; far: likewise
          of what other nodes have sent. Rows rows[r, 0] <= i < rows[r, 1] of block k stand at
          memory[begins[k, r]:]
plans     [k]: (width, columns of the plan, plan forward, plan backward) of block k, for `function`
========  ==========================================================================================
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
    """Call a C function of a plan and the memory of two arrays, all of them addresses."""

    def generate(context, builder, signature, values):
        pointer = ir.IntType(8).as_pointer()
        called = ir.FunctionType(ir.VoidType(), [pointer] * 3).as_pointer()
        arguments = [builder.inttoptr(value, pointer) for value in values[1:]]
        builder.call(builder.inttoptr(values[0], called), arguments)
        return context.get_dummy_value()

    return types.void(function, plan, source, target), generate


def no_rows(real):
    """Return `rows` of a thread for given real rows (R, n_y) that are never transformed."""
    nothing = np.zeros(1)
    return real, (nothing, nothing, np.zeros(1, np.int64), 0, (0, 0, 0, 0), (0, 0, 0, 0))


@kernel
def store_rows(spectra, i0, i1):
    """Transform the real rows i0 <= i < i1 of a pass and copy their spectra to the blocks."""
    half, blocks, edges, n_loc, (function, plan, source, target), _ = spectra
    transform(function, plan, source, target)
    words = edges[-1]
    for block in range(edges.shape[0] - 1):
        width = edges[block + 1] - edges[block]
        whole = width - width % WIDTH
        for i in range(i0, i1):
            to = n_loc * edges[block] + i * width
            begin = (i - i0) * words + edges[block]
            for w in range(0, whole, WIDTH):
                move_line(blocks, to + w, half, begin + w)
            for w in range(whole, width):
                blocks[to + w] = half[begin + w]


@kernel
def load_rows(spectra, i0, i1):
    """Copy spectra of rows i0 <= i < i1 from the blocks and transform them to real rows."""
    half, blocks, edges, n_loc, _, (function, plan, source, target) = spectra
    words = edges[-1]
    for block in range(edges.shape[0] - 1):
        width = edges[block + 1] - edges[block]
        whole = width - width % WIDTH
        for i in range(i0, i1):
            begin = n_loc * edges[block] + i * width
            to = (i - i0) * words + edges[block]
            for w in range(0, whole, WIDTH):
                move_line(half, to + w, blocks, begin + w)
            for w in range(whole, width):
                half[to + w] = blocks[begin + w]
    transform(function, plan, source, target)


@kernel
def load_columns(columns, k):
    """Fill a thread's scratch with the columns of its block k, transformed along x."""
    moved, address, near, far, function, plans = columns
    width = plans[k, 0]
    for w in range(width, plans[k, 1]):
        for i in range(moved.shape[1]):
            moved[w, i] = 0
    for memory, begins, rows in (near, far):
        _transpose(memory, begins[k], rows, moved, width)
    transform(function, plans[k, 2], address, address)


@inline
def store_columns(columns, k):
    """Transform the scratch back and write it to where `load_columns` read block k."""
    moved, address, near, far, function, plans = columns
    transform(function, plans[k, 3], address, address)
    for memory, begins, rows in (near, far):
        _transpose_back(moved, plans[k, 0], memory, begins[k], rows)


@inline
def _transpose(memory, begins, rows, columns, width):
    """Set columns[:width] = a block (n_x, width) transposed, a cache line of either at a time."""
    for r in range(begins.shape[0]):
        i0 = rows[r, 0]
        n = rows[r, 1] - i0
        whole = n - n % TILE
        for i in range(0, whole, TILE):
            for w in range(width):
                for j in range(TILE):
                    columns[w, i0 + i + j] = memory[begins[r] + (i + j) * width + w]
        for i in range(whole, n):
            for w in range(width):
                columns[w, i0 + i] = memory[begins[r] + i * width + w]


@inline
def _transpose_back(columns, width, memory, begins, rows):
    """Write columns[:width] transposed to the memory that `_transpose` reads."""
    for r in range(begins.shape[0]):
        i0 = rows[r, 0]
        n = rows[r, 1] - i0
        whole = n - n % TILE
        for i in range(0, whole, TILE):
            for w in range(width):
                for j in range(TILE):
                    memory[begins[r] + (i + j) * width + w] = columns[w, i0 + i + j]
        for i in range(whole, n):
            for w in range(width):
                memory[begins[r] + i * width + w] = columns[w, i0 + i]
