"""Storage of float32 in 16 bits, as in hpc_gfmd/kernels/bfloat16.py."""

import numpy as np
from numba import cuda

STILL = np.uint16(0)  # a step of 0
PROJECTED = np.uint16(0xFF80)  # minus infinity: marks a point that the projection put on g = 0
SHIFT = np.uint32(16)


@cuda.jit(device=True)
def encode(number):
    """Return the first 16 bits of a float32, as uint16."""
    return np.uint16(np.float32(number).view(np.uint32) >> SHIFT)


@cuda.jit(device=True)
def decode(stored):
    """Return the float32 that 16 bits stand for."""
    return np.uint32(np.uint32(stored) << SHIFT).view(np.float32)
