"""One halo row before and one after every rank's rows, periodic in the rank number. Arrays: (..., rows + 2, m)."""

import numpy as np


def _exchange(comm, up, down):
    """Send `up` to the next rank and `down` to the previous one; returns what came from the previous and from the next rank."""
    if comm.size == 1:
        return up, down
    before, after = np.empty_like(up), np.empty_like(down)
    nxt, prev = (comm.rank + 1) % comm.size, (comm.rank - 1) % comm.size
    comm.mpi.Sendrecv(up, dest=nxt, sendtag=1, recvbuf=before, source=prev, recvtag=1)
    comm.mpi.Sendrecv(down, dest=prev, sendtag=2, recvbuf=after, source=nxt, recvtag=2)
    return before, after


def fill(comm, a):
    """Copy the neighbours' own rows into the halo rows."""
    before, after = _exchange(comm, np.ascontiguousarray(a[..., -2, :]), np.ascontiguousarray(a[..., 1, :]))
    a[..., 0, :] = before
    a[..., -1, :] = after


def accumulate(comm, a):
    """Add the halo rows to the rows of the neighbours that own them."""
    before, after = _exchange(comm, np.ascontiguousarray(a[..., -1, :]), np.ascontiguousarray(a[..., 0, :]))
    a[..., 1, :] += before
    a[..., -2, :] += after


def sum_to_all(comm, a, start, n):
    """Every rank's rows with halo, the first own one being row `start` of n, summed into a whole array on every rank."""
    rows = a.shape[-2] - 2
    whole = np.zeros((*a.shape[:-2], n, a.shape[-1]), a.dtype)
    whole[..., start:start + rows, :] = a[..., 1:-1, :]
    whole[..., (start - 1) % n, :] += a[..., 0, :]
    whole[..., (start + rows) % n, :] += a[..., -1, :]
    if comm.size > 1:
        from mpi4py import MPI

        comm.mpi.Allreduce(MPI.IN_PLACE, whole, op=MPI.SUM)
    return whole


def take_rows(whole, start, a):
    """The inverse of `sum_to_all`: a = this rank's rows and halo out of the whole array."""
    n, rows = whole.shape[-2], a.shape[-2] - 2
    a[..., 1:-1, :] = whole[..., start:start + rows, :]
    a[..., 0, :] = whole[..., (start - 1) % n, :]
    a[..., -1, :] = whole[..., (start + rows) % n, :]


def neighbours(comm, a, width):
    """The `width` rows before and after this rank's rows a (rows, m). Collective."""
    if comm.size > 1 and comm.min([len(a)])[0] < width:  # rows of more than one rank on either side
        parts = comm.allgather(a)
        start, whole = sum(len(part) for part in parts[:comm.rank]), np.concatenate(parts)
        take = np.arange(width)
        return whole[(start + take - width) % len(whole)], whole[(start + len(a) + take) % len(whole)]
    if comm.size == 1:
        take = np.arange(width)
        return a[(take - width) % len(a)].copy(), a[take % len(a)].copy()
    return _exchange(comm, np.ascontiguousarray(a[-width:]), np.ascontiguousarray(a[:width]))


def next_row(comm, a):
    """The row after this rank's rows, of which a (..., >= 0 rows, m) has the first; periodic, ranks without rows are skipped."""
    if comm.size == 1:
        return a[..., 0, :].copy()
    if comm.min([a.shape[-2]])[0]:
        first = np.ascontiguousarray(a[..., 0, :])
        return _exchange(comm, first, first)[1]
    firsts = comm.allgather(a[..., 0, :].copy() if a.shape[-2] else None)
    order = [(comm.rank + 1 + k) % comm.size for k in range(comm.size)]
    return next(firsts[r] for r in order if firsts[r] is not None)
