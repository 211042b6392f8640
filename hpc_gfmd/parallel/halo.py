"""Rows of a field that other ranks own: windows of rows, filled from their owners or added to them.
Arrays: (..., rows, m).

The rows 0 <= i < n of a field form a ring. Rank r owns the rows starts[r] <= i < starts[r + 1],
perhaps none, and has a window lo[r] <= i < hi[r] of the ring, which may reach around it. Halo rows
are windows, and so are the rows that a rank has before they are agglomerated on fewer ranks. A rank
talks to those alone whose rows or windows meet its own.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike


@dataclass(frozen=True)
class Piece:
    """Rows that the window of one rank and the rows of another one have in common; peer: the other
    one, whoever that is here."""

    peer: int
    window: slice
    owned: slice

    def __len__(self) -> int:
        return self.owned.stop - self.owned.start


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
        self.own = [
            Piece(peer, slice(*here), slice(*there)) for peer, here, there in taken if peer == rank
        ]
        self.take = _by_peer(
            Piece(peer, slice(*here), slice(*there)) for peer, here, there in taken if peer != rank
        )
        self.give = _by_peer(
            Piece(peer, slice(*there), slice(*here)) for peer, here, there in given if peer != rank
        )

    def fill(self, comm: Any, owned: np.ndarray, window: np.ndarray) -> None:
        """Copy the rows of all windows from those that own them."""
        send = {
            peer: np.concatenate([owned[..., piece.owned, :] for piece in pieces], axis=-2)
            for peer, pieces in self.give.items()
        }
        receive = {peer: _room(pieces, window) for peer, pieces in self.take.items()}
        comm.exchange(send, receive)
        for piece in self._apart(owned, window):
            window[..., piece.window, :] = owned[..., piece.owned, :]
        for peer, pieces in self.take.items():
            for piece, rows in zip(pieces, _parts(pieces, receive[peer])):
                window[..., piece.window, :] = rows

    def add(self, comm: Any, window: np.ndarray, owned: np.ndarray) -> None:
        """Add the rows of all windows to those that own them: the transpose of `fill`."""
        send = {
            peer: np.concatenate([window[..., piece.window, :] for piece in pieces], axis=-2)
            for peer, pieces in self.take.items()
        }
        receive = {peer: _room(pieces, owned) for peer, pieces in self.give.items()}
        comm.exchange(send, receive)
        for piece in self._apart(owned, window):
            owned[..., piece.owned, :] += window[..., piece.window, :]
        for peer, pieces in self.give.items():
            for piece, rows in zip(pieces, _parts(pieces, receive[peer])):
                owned[..., piece.owned, :] += rows

    def _apart(self, owned: np.ndarray, window: np.ndarray) -> list[Piece]:
        """Own pieces of the own window that are not the same memory."""
        together = self.in_place and np.may_share_memory(owned, window)
        return [piece for piece in self.own if not (together and piece.window == self.interior)]

    def sent_rows(self, adding: bool) -> dict[int, int]:
        """{rank: rows sent to it} by `add` or by `fill`."""
        return {
            peer: sum(map(len, pieces))
            for peer, pieces in (self.take if adding else self.give).items()
        }


def _met(first: Any, last: Any, lo: Any, hi: Any, n: int, turns: Iterable[int]) -> Iterator[tuple]:
    """(rank, (rows of [first, last) counted from first), (rows of that rank's [lo, hi) counted from
    lo)) where [first, last) meets [lo, hi) of each rank shifted by some turns of the ring, in the
    order of the first interval for each turn."""
    for turn in turns:
        a, b = np.maximum(lo + turn * n, first), np.minimum(hi + turn * n, last)
        for rank in np.flatnonzero(a < b):
            begin, end, shift = int(a[rank]), int(b[rank]), int(lo[rank]) + turn * n
            yield int(rank), (begin - first, end - first), (begin - shift, end - shift)


def _by_peer(pieces: Iterable[Piece]) -> dict[int, list[Piece]]:
    """{peer: its pieces in the order of the window}: both sides of a message then have the same
    order."""
    found: dict[int, list[Piece]] = {}
    for piece in sorted(pieces, key=lambda piece: (piece.peer, piece.window.start)):
        found.setdefault(piece.peer, []).append(piece)
    return found


def _room(pieces: Sequence[Piece], like: np.ndarray) -> np.ndarray:
    return np.empty((*like.shape[:-2], sum(map(len, pieces)), like.shape[-1]), like.dtype)


def _parts(pieces: Sequence[Piece], rows: np.ndarray) -> list[np.ndarray]:
    return np.split(rows, np.cumsum([len(piece) for piece in pieces])[:-1], axis=-2)


def rows_of(
    comm: Any,
    a: np.ndarray,
    starts: ArrayLike,
    lo: np.ndarray,
    hi: np.ndarray,
    n: int | None = None,
) -> np.ndarray:
    """The rows lo[rank] <= i < hi[rank] of the field of which this rank's part is a; rows that
    belong to nobody are 0. Collective."""
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
    """The `width` rows before and after the rows of this rank, as `starts` has them. owned: the
    starts of those that a field has on each rank, if these are not all. Collective."""
    first, last = np.asarray(starts)[:-1], np.asarray(starts)[1:]
    owned, n = starts if owned is None else owned, int(starts[-1])
    return rows_of(comm, a, owned, first - width, first, n), rows_of(
        comm, a, owned, last, last + width, n
    )


def next_row(comm: Any, a: np.ndarray, starts: ArrayLike) -> np.ndarray:
    """The row after this rank's rows a (..., rows, m); starts: first row of every rank, and their
    number. Periodic. Collective."""
    last = np.asarray(starts)[1:]
    return rows_of(comm, a, starts, last, last + 1)[..., 0, :]
