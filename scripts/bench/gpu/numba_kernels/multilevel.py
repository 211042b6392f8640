"""Restriction and smoothing of one level, letters as in hpc_gfmd/kernels/multilevel.py.

A thread has a coarse column c and goes down a strip of rows. Coarse row J, halo rows counted, lies
on own fine row 2 (J - 1), which is row 2 J - 1 of an array with halo rows.
"""

import numpy as np
from numba import cuda

from .launch import HALF, STRIP, THREADS, ZERO, blocks_of, launch, partial_sums, sum_of_block

SUMS = 7  # that smooth_on_rows returns
QUARTER = np.float32(0.25)  # factor of a transfer to half the points along both axes


def restrict_on_rows(fine, coarse, i0, i1):
    """Restrict fields to the coarse rows that own rows i0 <= i < i1 lie on or after.

    Parameters
    ----------
    fine : (>= fields, rows + 2, n)
        Its own rows are read.
    coarse : (fields, coarse rows + 2, m)
        Gets the result, with the last own row also in the coarse row after it.
    i0, i1 : int
        Own rows; even.
    """
    launch(restrict_fields, blocks_of(i1 - i0, coarse.shape[2]), THREADS, fine, coarse, i0, i1)


def smooth_on_rows(fields, z_coarse, out, weight, damping, i0, i1):
    """Set z = r/(weight + damping t) + P z_coarse on own rows i0 <= i < i1 of a level.

    Parameters
    ----------
    fields : (2 or 3, rows + 2, n)
        r, t and perhaps a third field x.
    z_coarse : (coarse rows + 2, m)
        z of the next coarser level, with valid halo rows.
    out : (rows + 2, n)
        Gets z; may be the memory of r.
    weight, damping : float
        Of this level, in the precision of the fields.
    i0, i1 : int
        Own rows; even.

    Returns
    -------
    array (blocks, SUMS) float64
        <r, z>, <x, z>, <r, r>, <t, t>, <r, t>, and the sums of t and r, in parts.
    """
    blocks = blocks_of(i1 - i0, z_coarse.shape[1])
    partial = partial_sums(fields, blocks, SUMS)
    arguments = (fields, z_coarse, out, weight, damping, i0, i1, partial)
    launch(smooth_fields, blocks, THREADS, *arguments)
    return partial


@cuda.jit(device=True)
def weighted_row(fine, field, i, c):
    """Return own row i beside coarse column c: point 2 c and half of its neighbours."""
    j = 2 * c
    before = j - 1 if c > 0 else fine.shape[2] - 1
    return fine[field, i + 1, j] + HALF * (fine[field, i + 1, j + 1] + fine[field, i + 1, before])


@cuda.jit
def restrict_fields(fine, coarse, i0, i1):
    """Restrict fields, as `restrict_on_rows` describes."""
    c = cuda.blockIdx.x * THREADS + cuda.threadIdx.x
    start = i0 + cuda.blockIdx.y * STRIP
    end = min(start + STRIP, i1)
    if c >= coarse.shape[2]:
        return
    for field in range(coarse.shape[0]):
        above = HALF * weighted_row(fine, field, start - 1, c) if start > 0 else ZERO
        for i in range(start, end, 2):
            below = HALF * weighted_row(fine, field, i + 1, c)
            coarse[field, i // 2 + 1, c] = QUARTER * (
                above + weighted_row(fine, field, i, c) + below
            )
            above = below
        if end == fine.shape[1] - 2:
            coarse[field, end // 2 + 1, c] = QUARTER * above


@cuda.jit
def smooth_fields(fields, z_coarse, out, weight, damping, i0, i1, partial):
    """Set z on rows i0 <= i < i1, as `smooth_on_rows` describes; partial gets its sums."""
    shared = cuda.shared.array(THREADS, np.float64)
    m = z_coarse.shape[1]
    c = cuda.blockIdx.x * THREADS + cuda.threadIdx.x
    start = i0 + cuda.blockIdx.y * STRIP
    end = min(start + STRIP, i1)
    rz = xz = rr = tt = rt = t_sum = r_sum = ZERO
    if c < m:
        c_next = c + 1 if c + 1 < m else 0
        for i in range(start, end):
            J = i // 2 + 1
            left = z_coarse[J, c]
            right = z_coarse[J, c_next]
            if i % 2 == 1:
                left = HALF * (left + z_coarse[J + 1, c])
                right = HALF * (right + z_coarse[J + 1, c_next])
            for k in range(2):
                j = 2 * c + k
                r = fields[0, i + 1, j]
                t = fields[1, i + 1, j]
                Pz = left if k == 0 else HALF * (left + right)
                z = r / (weight + damping * t) + Pz
                rz += r * z
                rr += r * r
                tt += t * t
                rt += r * t
                t_sum += t
                r_sum += r
                if fields.shape[0] > 2:
                    xz += fields[2, i + 1, j] * z
                out[i + 1, j] = z
    sum_of_block(rz, shared, partial, 0)
    sum_of_block(xz, shared, partial, 1)
    sum_of_block(rr, shared, partial, 2)
    sum_of_block(tt, shared, partial, 3)
    sum_of_block(rt, shared, partial, 4)
    sum_of_block(t_sum, shared, partial, 5)
    sum_of_block(r_sum, shared, partial, 6)
