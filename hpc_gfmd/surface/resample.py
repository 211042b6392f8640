"""Resampling of a map by its Fourier series; with fewer points the shortest waves are lost.

Along an axis with free edges it is the series of cosines, that of the map with its mirror image,
which has no jump at the edge.
"""

import numpy as np


def resampled(z: np.ndarray, n: tuple[int, int], free: tuple[bool, bool]) -> np.ndarray:
    """Return heights resampled to n points along x and y, where edges are free or periodic."""
    for axis in (1, 0):
        z = _series(z, n[axis], axis, free[axis])
    return z


def _series(z: np.ndarray, n: int, axis: int, is_free: bool) -> np.ndarray:
    """Return heights resampled to n points along an axis, in cosines if its edges are free."""
    from scipy.fft import dct, idct
    from scipy.signal import resample

    if not is_free:
        return resample(z, n, axis=axis)
    return idct(dct(z, axis=axis, norm="forward"), n=n, axis=axis, norm="forward")
