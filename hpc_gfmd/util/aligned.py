"""Memory for fields that begins on a cache line: vectors loaded from it never straddle two
lines."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import DTypeLike

LINE = 64  # bytes


def empty_aligned(shape: Sequence[int], dtype: DTypeLike) -> np.ndarray:
    """Make an uninitialised C-contiguous array whose first element is aligned to LINE bytes."""
    nbytes = math.prod(shape) * np.dtype(dtype).itemsize
    raw = np.empty(nbytes + LINE, np.uint8)
    start = -raw.ctypes.data % LINE
    return raw[start : start + nbytes].view(dtype).reshape(shape)


def zeros_aligned(shape: Sequence[int], dtype: DTypeLike) -> np.ndarray:
    """Make the same, zeroed."""
    a = empty_aligned(shape, dtype)
    a[...] = 0
    return a
