"""Rows of a field that other ranks own: windows of rows, filled from their owners or added to them.
Arrays: (..., rows, m).

The rows 0 <= i < n of a field form a ring. Rank r owns the rows starts[r] <= i < starts[r + 1],
perhaps none, and has a window lo[r] <= i < hi[r] of the ring, which may reach around it. Halo rows
are windows, and so are the rows that a rank has before they are agglomerated on fewer ranks. A rank
talks to those alone whose rows or windows meet its own.
"""

from collections.abc import Iterable, Iterator
from functools import lru_cache
from operator import itemgetter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

Pieces = dict[int, list[slice]]  # rows of an array by the rank that they go to, or come from


class Windows:
    """Who has to send which rows to whom; no memory, no message. n: length of the ring, more than
    starts[-1] where the last rows belong to nobody: those are left as they are."""

    def __init__(
        self, rank: int, starts: ArrayLike, lo: np.ndarray, hi: np.ndarray, n: int | None = None
    ):
        starts, lo, hi = (np.asarray(a, np.int64) for a in (starts, lo, hi))
        n = int(starts[-1]) if n is None else n
        self.rank = rank
        taken = list(
            _met(
                int(lo[rank]),
                int(hi[rank]),
                starts[:-1],
                starts[1:],
                n,
                range(lo[rank] // n, -(-hi[rank] // n)),
            )
        )
        turns = range(int(lo.min()) // n, -(-int(hi.max()) // n))
        given = list(_met(int(starts[rank]), int(starts[rank + 1]), lo, hi, n, [-t for t in turns]))
        # A halo around a rank's own rows lives in one array with them, which then has nothing to be
        # copied.
        width = int(starts[0] - lo[0])
        self.in_place = bool(
            np.all((hi <= lo) | ((starts[:-1] - lo == width) & (hi - starts[1:] == width)))
        )
        self.interior = slice(width, width + int(starts[rank + 1] - starts[rank]))
        # (rows of the window, own rows); by peer: rows of the window, own rows
        self.own = [(slice(*w), slice(*o)) for peer, w, o in taken if peer == rank]
        self.take = _by_peer((peer, w[0], slice(*w)) for peer, w, _ in taken if peer != rank)
        self.give = _by_peer((peer, w[0], slice(*o)) for peer, o, w in given if peer != rank)

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
        together = self.in_place and np.may_share_memory(owned, window)
        return [piece for piece in self.own if not (together and piece[0] == self.interior)]

    def sent_rows(self, adding: bool) -> dict[int, int]:
        """Return {rank: rows sent to it} by `add` or by `fill`."""
        sent = self.take if adding else self.give
        return {peer: sum(map(_length, pieces)) for peer, pieces in sent.items()}


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


def _met(first: Any, last: Any, lo: Any, hi: Any, n: int, turns: Iterable[int]) -> Iterator[tuple]:
    """Yield (rank, (rows of [first, last) counted from first), (rows of that rank's [lo, hi)
    counted from lo)) where [first, last) meets [lo, hi) of each rank shifted by some turns of the
    ring, in the order of the first interval for each turn."""
    for turn in turns:
        a, b = np.maximum(lo + turn * n, first), np.minimum(hi + turn * n, last)
        for rank in np.flatnonzero(a < b):
            begin, end, shift = int(a[rank]), int(b[rank]), int(lo[rank]) + turn * n
            yield int(rank), (begin - first, end - first), (begin - shift, end - shift)


def _by_peer(pieces: Iterable[tuple[int, int, slice]]) -> Pieces:
    """Return {peer: rows} of (peer, first row in the window, rows), in the order of the window:
    both sides of a message then have the same order."""
    found: Pieces = {}
    for peer, _, rows in sorted(pieces, key=itemgetter(0, 1)):
        found.setdefault(peer, []).append(rows)
    return found


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
    _windows(
        comm.rank, n, *(np.asarray(rows, np.int64).tobytes() for rows in (starts, lo, hi))
    ).fill(comm, a, window)
    return window


@lru_cache(maxsize=64)
def _windows(rank: int, n: int | None, *rows: bytes) -> Windows:
    starts, lo, hi = (np.frombuffer(one, np.int64) for one in rows)
    return Windows(rank, starts, lo, hi, n)


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
