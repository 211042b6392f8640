"""Arrays that begin on a cache line, so that no vector load straddles two lines."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import DTypeLike

LINE = 64  # bytes


def empty_aligned(shape: Sequence[int], dtype: DTypeLike) -> np.ndarray:
    """Make an uninitialised C-contiguous array that begins on a cache line (LINE bytes)."""
    nbytes = math.prod(shape) * np.dtype(dtype).itemsize
    raw = np.empty(nbytes + LINE, np.uint8)
    start = -raw.ctypes.data % LINE
    return raw[start : start + nbytes].view(dtype).reshape(shape)


def zeros_aligned(shape: Sequence[int], dtype: DTypeLike) -> np.ndarray:
    """Make a C-contiguous array of zeros that begins on a cache line (LINE bytes)."""
    zeros = empty_aligned(shape, dtype)
    zeros[...] = 0
    return zeros
