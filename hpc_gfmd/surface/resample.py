"""The same Fourier series on another number of points (fewer: without its shortest waves); along an
axis where the map ends the series of its mirror images, in cosines, which has no jump there."""

from typing import Any

import numpy as np

from ..parallel.layout import row_starts
from .slabs import local, own_rows, own_slabs
from .topography import Topography


def resampled(
    found: Topography, n: tuple[int, int], free: tuple[bool, bool], comm: Any
) -> Topography:
    """A Topography of n points; only this rank's rows of it can be read. free: whether it ends
    along x, along y. Collective."""

    def along_y() -> np.ndarray:
        slabs = own_slabs(found.n[0], comm)
        rows = (_series(found.rows(*slab), n[1], 1, free[1]) for slab in slabs)
        return np.concatenate([np.zeros((0, n[1])), *rows])

    z = local(comm, along_y)
    starts, columns = (row_starts(k, comm.size) for k in n)
    z = np.concatenate(comm.alltoall([z[:, a:b] for a, b in zip(columns, columns[1:])]))
    z = _series(z, n[0], 0, free[0])
    z = np.concatenate(comm.alltoall([z[a:b] for a, b in zip(starts, starts[1:])]), axis=1)
    first = own_rows(n[0], comm)[0]
    return found.after(
        f"resampled to {n[0]} x {n[1]} points",
        n=n,
        rows=lambda start, stop: z[start - first : stop - first],
    )


def _series(z: np.ndarray, n: int, axis: int, ends: bool) -> np.ndarray:
    from scipy.fft import dct, idct
    from scipy.signal import resample

    if not ends:
        return resample(z, n, axis=axis)
    return idct(dct(z, axis=axis, norm="forward"), n=n, axis=axis, norm="forward")
