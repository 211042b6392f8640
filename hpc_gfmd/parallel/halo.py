"""Rows of a field that other ranks own: windows of rows, filled from their owners or added to them.
Arrays: (..., rows, m).

The rows 0 <= i < n of a field form a ring. Rank r owns the rows starts[r] <= i < starts[r + 1],
perhaps none, and has a window lo[r] <= i < hi[r] of the ring, which may reach around it. Halo rows
are windows, and so are the rows that a rank has before they are agglomerated on fewer ranks. A rank
talks to those alone whose rows or windows meet its own.
"""

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

Pieces = dict[int, list[slice]]  # rows of an array by the rank that they go to, or come from


class Windows:
    """Who has to send which rows to whom; no memory, no message. n: length of the ring, more than
    starts[-1] where the last rows belong to nobody: those are left as they are."""

    def __init__(
        self, rank: int, starts: ArrayLike, lo: ArrayLike, hi: ArrayLike, n: int | None = None
    ):
        starts, lo, hi = (np.asarray(a, np.int64) for a in (starts, lo, hi))
        n = int(starts[-1]) if n is None else n
        self.rank = rank
        # this rank takes from all, and others take from it
        ranks = np.arange(len(lo))
        others = np.delete(ranks, rank)
        taker = np.append(np.full(len(ranks), rank), others)
        owner = np.append(ranks, np.full(len(others), rank))
        pieces: list[list[int]] = []
        for turn in range(int(lo.min()) // n, -(-int(hi.max()) // n)):
            first, last = starts[owner] + turn * n, starts[owner + 1] + turn * n
            begin = np.maximum(first, lo[taker])
            length = np.minimum(last, hi[taker]) - begin
            found = np.stack([taker, owner, begin - lo[taker], begin - first, length], axis=1)
            pieces += found[length > 0].tolist()
        # (rows of the window, own rows); by peer: rows of the window, own rows
        self.own: list[tuple[slice, slice]] = []
        self.take: Pieces = {}
        self.give: Pieces = {}
        for to, source, at, own_at, count in sorted(pieces):  # in the order of the window
            in_window, in_own = slice(at, at + count), slice(own_at, own_at + count)
            if to == source:
                self.own.append((in_window, in_own))
            elif to == rank:
                self.take.setdefault(source, []).append(in_window)
            else:
                self.give.setdefault(to, []).append(in_own)
        # where an array of a rank's own rows and a halo is given as both
        begin = int(starts[rank] - lo[rank])
        self.interior = slice(begin, begin + int(starts[rank + 1] - starts[rank]))

    def fill(self, comm: Any, owned: np.ndarray, window: np.ndarray) -> None:
        """Copy the rows of all windows from those that own them."""
        received = _exchange(comm, owned, self.give, window, self.take)
        for rows, own in self._apart(owned, window):
            window[..., rows, :] = owned[..., own, :]
        for rows, values in received:
            window[..., rows, :] = values

    def add(self, comm: Any, window: np.ndarray, owned: np.ndarray) -> None:
        """Add the rows of all windows to those that own them: the transpose of `fill`."""
        received = _exchange(comm, window, self.take, owned, self.give)
        for rows, own in self._apart(owned, window):
            owned[..., own, :] += window[..., rows, :]
        for own, values in received:
            owned[..., own, :] += values

    def _apart(self, owned: np.ndarray, window: np.ndarray) -> list[tuple[slice, slice]]:
        """List own pieces of the own window that are not the same memory."""
        together = np.may_share_memory(owned, window)
        return [piece for piece in self.own if not (together and piece[0] == self.interior)]

    def sent_rows(self, adding: bool) -> dict[int, int]:
        """Return {rank: rows sent to it} by `add` or by `fill`."""
        sent = self.take if adding else self.give
        return {peer: sum(map(_length, pieces)) for peer, pieces in sent.items()}


_windows = lru_cache(maxsize=64)(Windows)


def _exchange(comm: Any, a: np.ndarray, give: Pieces, b: np.ndarray, take: Pieces) -> list[tuple]:
    """Send rows of a to other ranks; returns (rows of b, their values) for what they send."""
    send = {
        peer: np.concatenate([a[..., rows, :] for rows in pieces], axis=-2)
        for peer, pieces in give.items()
    }
    receive = {
        peer: np.empty((*b.shape[:-2], sum(map(_length, pieces)), b.shape[-1]), b.dtype)
        for peer, pieces in take.items()
    }
    comm.exchange(send, receive)
    return [
        piece
        for peer, pieces in take.items()
        for piece in zip(
            pieces, np.split(receive[peer], np.cumsum([*map(_length, pieces)])[:-1], axis=-2)
        )
    ]


def _length(rows: slice) -> int:
    return rows.stop - rows.start


def rows_of(
    comm: Any,
    a: np.ndarray,
    starts: ArrayLike,
    lo: np.ndarray,
    hi: np.ndarray,
    n: int | None = None,
) -> np.ndarray:
    """Gather the rows lo[rank] <= i < hi[rank] of the field of which this rank's part is a; rows
    that belong to nobody are 0. Collective."""
    window = np.zeros((*a.shape[:-2], int(hi[comm.rank] - lo[comm.rank]), a.shape[-1]), a.dtype)
    rows = (tuple(np.asarray(ends).tolist()) for ends in (starts, lo, hi))
    _windows(comm.rank, *rows, n).fill(comm, a, window)
    return window


def neighbours(
    comm: Any, a: np.ndarray, starts: np.ndarray, width: int, owned: ArrayLike | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Gather the `width` rows before and after the rows of this rank, as `starts` has them. owned:
    the starts of those that a field has on each rank, if these are not all. Collective."""
    first, last = np.asarray(starts)[:-1], np.asarray(starts)[1:]
    owned, n = starts if owned is None else owned, int(starts[-1])
    return rows_of(comm, a, owned, first - width, first, n), rows_of(
        comm, a, owned, last, last + width, n
    )


def next_row(comm: Any, a: np.ndarray, starts: ArrayLike) -> np.ndarray:
    """Gather the row after this rank's rows a (..., rows, m); starts: first row of every rank, and
    their number. Periodic. Collective."""
    last = np.asarray(starts)[1:]
    return rows_of(comm, a, starts, last, last + 1)[..., 0, :]
