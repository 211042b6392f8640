"""The same Fourier series on another number of points (fewer: without its shortest waves); along an
axis where the map ends the series of its mirror images, in cosines, which has no jump there."""

from typing import Any

import numpy as np

from ..parallel.guard import collective_errors
from ..parallel.layout import row_starts
from .topography import Topography


def resampled(
    found: Topography, n: tuple[int, int], free: tuple[bool, bool], comm: Any
) -> Topography:
    """Return a Topography of n points, of which only this rank's rows can be read. free: whether it
    ends along x, along y. Collective."""
    before, rows, columns = (row_starts(k, comm.size) for k in (found.n[0], *n))
    with collective_errors(comm, "reading the surface"):
        z = _series(found.rows(*before[comm.rank :][:2]), n[1], 1, free[1])
    z = _series(_columns(z, before, columns, comm), n[0], 0, free[0])
    z, first = _columns(z.T, columns, rows, comm).T, rows[comm.rank]
    return found.after(
        f"resampled to {n[0]} x {n[1]} points",
        n=n,
        rows=lambda start, stop: z[start - first : stop - first],
    )


def _columns(z: np.ndarray, rows: np.ndarray, columns: np.ndarray, comm: Any) -> np.ndarray:
    """Turn this rank's rows z of a field into its columns, all rows of them; rows, columns: where
    those of each rank begin, and how many there are. Collective."""
    whole = np.empty((rows[-1], np.diff(columns)[comm.rank]))
    receive = dict(enumerate(np.split(whole, rows[1:-1])))
    send = dict(enumerate(map(np.ascontiguousarray, np.split(z, columns[1:-1], axis=1))))
    receive.pop(comm.rank)[...] = send.pop(comm.rank)
    comm.exchange(send, receive)
    return whole


def _series(z: np.ndarray, n: int, axis: int, ends: bool) -> np.ndarray:
    from scipy.fft import dct, idct
    from scipy.signal import resample

    if not ends:
        return resample(z, n, axis=axis)
    return idct(dct(z, axis=axis, norm="forward"), n=n, axis=axis, norm="forward")
