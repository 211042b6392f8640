"""Resampling by Fourier series, of cosines along free axes, which have no jump at the edge; with
fewer points the shortest waves are lost.
"""

import numpy as np

LINES = 64  # transformed at a time


def resampled(z: np.ndarray, n: tuple[int, int], free: tuple[bool, bool]) -> np.ndarray:
    """Return heights resampled to n points along x and y, where edges are free or periodic."""
    along_y = np.empty((z.shape[0], n[1]))
    _transform(z, along_y, free[1])
    along_both = np.empty(n)
    _transform(along_y.T, along_both.T, free[0])
    return along_both


def _transform(lines: np.ndarray, out: np.ndarray, is_free: bool) -> None:
    """Resample lines to those of `out`, by cosines if their ends are free."""
    from scipy.fft import dct, idct
    from scipy.signal import resample

    n = out.shape[1]
    for i in range(0, len(lines), LINES):
        piece = lines[i : i + LINES]
        out[i : i + LINES] = (
            idct(dct(piece, norm="forward"), n=n, norm="forward")
            if is_free
            else resample(piece, n, axis=1)
        )
