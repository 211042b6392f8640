"""The same Fourier series on another number of points (fewer: without its shortest waves); along an
axis where the map ends the series of its mirror images, in cosines, which has no jump there."""

from typing import Any

import numpy as np

from ..parallel.layout import row_starts
from .slabs import local, own_slabs
from .topography import Topography


def resampled(
    found: Topography, n: tuple[int, int], free: tuple[bool, bool], comm: Any
) -> Topography:
    """Return a Topography of n points, of which only this rank's rows can be read. free: whether it
    ends along x, along y. Collective."""

    def along_y() -> np.ndarray:
        slabs = own_slabs(found.n[0], comm)
        rows = (_series(found.rows(*slab), n[1], 1, free[1]) for slab in slabs)
        return np.concatenate([np.zeros((0, n[1])), *rows])

    z, me = local(comm, along_y), comm.rank
    before, rows, columns = (row_starts(k, comm.size) for k in (found.n[0], *n))
    parts = [z[:, a:b] for a, b in zip(columns, columns[1:])]
    shapes = [(k, parts[me].shape[1]) for k in np.diff(before)]
    z = _series(np.concatenate(_exchanged(parts, shapes, comm)), n[0], 0, free[0])
    parts = [z[a:b] for a, b in zip(rows, rows[1:])]
    shapes = [(len(parts[me]), k) for k in np.diff(columns)]
    z, first = np.concatenate(_exchanged(parts, shapes, comm), axis=1), rows[me]
    return found.after(
        f"resampled to {n[0]} x {n[1]} points",
        n=n,
        rows=lambda start, stop: z[start - first : stop - first],
    )


def _exchanged(parts: list, shapes: list, comm: Any) -> list[np.ndarray]:
    """Give each rank its part; returns what all ranks have for this one, of these shapes.
    Collective."""
    found, others = [np.empty(shape) for shape in shapes], {*range(comm.size)} - {comm.rank}
    found[comm.rank] = parts[comm.rank]
    send = {rank: np.ascontiguousarray(parts[rank]) for rank in others}
    comm.exchange(send, {rank: found[rank] for rank in others})
    return found


def _series(z: np.ndarray, n: int, axis: int, ends: bool) -> np.ndarray:
    from scipy.fft import dct, idct
    from scipy.signal import resample

    if not ends:
        return resample(z, n, axis=axis)
    return idct(dct(z, axis=axis, norm="forward"), n=n, axis=axis, norm="forward")
