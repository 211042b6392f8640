"""Resampling of a map by its Fourier series; with fewer points the shortest waves are lost.

Along an axis with free edges it is the series of cosines, that of the map with its mirror image,
which has no jump at the edge.
"""

from typing import Any

import numpy as np

from ..parallel.guard import collective_errors
from ..parallel.layout import row_starts
from .analytic import Rows
from .cell import grid_of, nominal_part
from .slabs import slabs
from .topography import Topography


def resampled(
    topography: Topography, n: tuple[int, int], free: tuple[bool, bool], comm: Any
) -> Topography:
    """Resample a height map to n points; reads it and exchanges all heights. Collective.

    Parameters
    ----------
    topography : Topography
        Not changed.
    n : (int, int)
        Points along x and y.
    free : (bool, bool)
        Whether the edges are free along x, along y.
    comm : Comm

    Returns
    -------
    Topography
        Each rank can read only the rows that it has of the Surface; it holds them in memory.
    """
    rows_read = row_starts(topography.n[0], comm.size)
    columns = row_starts(n[1], comm.size)
    rows_wanted = nominal_part(grid_of(n, topography.sizes, comm, free)).starts
    turned = _resampled_columns(topography.rows, rows_read, columns, free[1], comm)
    rows = _resampled_columns(turned, columns, rows_wanted, free[0], comm)
    return topography.after(f"resampled to {n[0]} x {n[1]} points", n=n, rows=rows)


def _resampled_columns(
    rows: Rows, before: np.ndarray, after: np.ndarray, ends: bool, comm: Any
) -> Rows:
    """Resample the rows of a map to after[-1] points each and transpose the map. Collective.

    rows: reads rows of the map. before: the first row of each rank, then the number of rows. after:
    the first of the resampled columns that each rank gets, then their number. ends: whether the
    edges are free along the rows, which then are resampled in cosines. Returns a function
    (start, stop) that gives this rank's columns as rows and raises IndexError for others.
    """
    me = comm.rank
    begin, stop_row = before[me : me + 2]
    column, end = after[me : me + 2]
    with collective_errors(comm, "reading the surface"):
        whole = np.empty((before[-1], end - column))
        receive = dict(enumerate(np.split(whole, before[1:-1])))
        send = {rank: np.empty((stop_row - begin, k)) for rank, k in enumerate(np.diff(after))}
        send[me] = receive.pop(me)
        for i, j in slabs(begin, stop_row):
            z = _series(rows(i, j), after[-1], ends)
            for part, columns in zip(send.values(), np.split(z, after[1:-1], axis=1)):
                part[i - begin : j - begin] = columns
    del send[me]
    comm.exchange(send, receive)

    def turned(start: int, stop: int) -> np.ndarray:
        if not column <= start <= stop <= end:
            raise IndexError(f"rows {start} to {stop} are not of this rank")
        return whole[:, start - column : stop - column].T

    return turned


def _series(z: np.ndarray, n: int, ends: bool) -> np.ndarray:
    """Return rows z, shape (k, m), resampled to n points by their Fourier series, shape (k, n).

    ends: use the series of cosines, for rows with free ends.
    """
    from scipy.fft import dct, idct
    from scipy.signal import resample

    if not ends:
        return resample(z, n, axis=1)
    return idct(dct(z, norm="forward"), n=n, norm="forward")
