"""Rows (..., rows, m) that other ranks own: windows filled from their owners or added to them.

The rows of a field form a ring. Rank r owns rows starts[r] <= i < starts[r + 1], perhaps none, and
has a window lo[r] <= i < hi[r], which may reach around the ring: halo rows, or the rows that a rank
has before they are agglomerated on fewer ranks.
"""

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

Pieces = dict[int, list[slice]]  # rows of an array by the rank that they go to, or come from


class Windows:
    """Which rank sends which rows to which, to fill windows of rows that others own.

    Rows from starts[-1] to n belong to no rank and stay. `own` lists rows of the window among its
    own; `take` and `give`, by rank, rows that come and go; `interior`: own rows between halo rows.
    """

    def __init__(
        self, rank: int, starts: ArrayLike, lo: ArrayLike, hi: ArrayLike, n: int | None = None
    ):
        starts, lo, hi = (np.asarray(bounds, np.int64) for bounds in (starts, lo, hi))
        n = int(starts[-1]) if n is None else n
        self.rank = rank
        # (rows of the window, own rows); by peer: rows of the window, own rows
        self.own: list[tuple[slice, slice]] = []
        self.take: Pieces = {}
        self.give: Pieces = {}
        pieces = _common(rank, starts[:-1], starts[1:], lo, hi, n)
        in_order_of_windows = sorted(pieces, key=lambda piece: (piece[1], piece[0], piece[3]))
        for source, to, own_at, at, count in in_order_of_windows:
            in_window = slice(at, at + count)
            in_own = slice(own_at, own_at + count)
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
        """Copy the rows of all windows from the ranks that own them. Collective."""
        received = _exchange(comm, owned, self.give, window, self.take)
        for rows, owned_rows in self._apart(owned, window):
            window[..., rows, :] = owned[..., owned_rows, :]
        for rows, values in received:
            window[..., rows, :] = values

    def add(self, comm: Any, window: np.ndarray, owned: np.ndarray) -> None:
        """Add the rows of all windows to those of their owners: adjoint of `fill`. Collective."""
        received = _exchange(comm, window, self.take, owned, self.give)
        for rows, owned_rows in self._apart(owned, window):
            owned[..., owned_rows, :] += window[..., rows, :]
        for owned_rows, values in received:
            owned[..., owned_rows, :] += values

    def _apart(self, owned: np.ndarray, window: np.ndarray) -> list[tuple[slice, slice]]:
        """List (rows of the window, own rows) to be copied, without those of the same memory."""
        is_same_memory = np.may_share_memory(owned, window)
        return [piece for piece in self.own if not (is_same_memory and piece[0] == self.interior)]


class Overlaps:
    """Rows that windows have in common, of which each has part of a sum. `parts`: terms (source,
    its rows, this rank's), in one order on all ranks; `common`: rows that others have too; `give`:
    by rank.
    """

    def __init__(self, rank: int, lo: ArrayLike, hi: ArrayLike, n: int):
        lo, hi = (np.asarray(bounds, np.int64) for bounds in (lo, hi))
        self.give: Pieces = {}
        # in the order of ranks, then of rows of their windows
        self.parts: list[tuple[int, slice, slice]] = []
        for source, to, at, to_at, count in _common(rank, lo, hi, lo, hi, n):
            if source == to and at == to_at:  # all of itself
                continue
            if to == rank:
                self.parts.append((source, slice(at, at + count), slice(to_at, to_at + count)))
            else:
                self.give.setdefault(to, []).append(slice(at, at + count))
        self.common = _joined([to_rows for _, _, to_rows in self.parts])
        self.parts += [(rank, rows, rows) for rows in self.common]
        self.parts.sort(key=lambda part: (part[0], part[1].start))

    @property
    def taken_rows(self) -> dict[int, int]:
        """Number of rows that come from each rank, this one included."""
        taken: dict[int, int] = {}
        for peer, _, rows in self.parts:
            taken[peer] = taken.get(peer, 0) + _length(rows)
        return taken


def add_overlaps(comm: Any, overlaps: Sequence[Overlaps], windows: Sequence[np.ndarray]) -> None:
    """Replace shared rows of windows (..., rows, m) by their sum over ranks, in place, in one
    message a pair. Collective.
    """
    fields = list(zip(overlaps, windows))
    give: dict[int, list[np.ndarray]] = {}
    take: dict[int, int] = {}
    for rows_of_field, window in fields:
        for peer, pieces in rows_of_field.give.items():
            give.setdefault(peer, []).extend(window[..., rows, :].ravel() for rows in pieces)
        row_size = window[..., :1, :].size
        for peer, count in rows_of_field.taken_rows.items():
            take[peer] = take.get(peer, 0) + count * row_size
    take.pop(comm.rank, None)
    received = {peer: np.empty(count, windows[0].dtype) for peer, count in take.items()}
    comm.exchange({peer: np.concatenate(parts) for peer, parts in give.items()}, received)
    begin = dict.fromkeys(received, 0)
    for rows_of_field, window in fields:
        own_parts = [
            window[..., rows, :].copy()
            for peer, rows, _ in rows_of_field.parts
            if peer == comm.rank
        ]
        for rows in rows_of_field.common:
            window[..., rows, :] = 0
        for peer, _, rows in rows_of_field.parts:
            target = window[..., rows, :]
            if peer == comm.rank:
                target += own_parts.pop(0)
            else:
                stop = begin[peer] + target.size
                target += received[peer][begin[peer] : stop].reshape(target.shape)
                begin[peer] = stop


def add_all(
    comm: Any, window: np.ndarray, bounds: Sequence[tuple[int, int]], whole: np.ndarray
) -> None:
    """Set `whole` (fields, n, m) on every rank to the sum of all windows. Collective."""
    fields, n, m = whole.shape
    counts = [fields * (hi - lo) * m for lo, hi in bounds]
    received = np.empty(sum(counts), window.dtype)
    comm.allgather_arrays(window.ravel(), received, counts)
    whole[...] = 0
    for (lo, hi), numbers in zip(bounds, np.split(received, np.cumsum(counts)[:-1])):
        part = numbers.reshape(fields, hi - lo, m)
        for start in range(lo // n * n, hi, n):  # the rows of a turn around the ring
            begin = max(lo, start)
            end = min(hi, start + n)
            whole[:, begin - start : end - start] += part[:, begin - lo : end - lo]


def _common(
    rank: int, begin: np.ndarray, end: np.ndarray, lo: np.ndarray, hi: np.ndarray, n: int
) -> list[list[int]]:
    """List rows that ranges of ranks, begin to end, have in common with windows lo to hi on a ring
    of n rows: (rank of the range, of the window, first row in it, in the window, rows) in ascending
    order, those of this rank.
    """
    ranks = np.arange(len(lo))
    other_ranks = np.delete(ranks, rank)
    # this rank takes from all, and others take from it
    owner = np.append(ranks, np.full(len(other_ranks), rank))
    taker = np.append(np.full(len(ranks), rank), other_ranks)
    pieces: list[list[int]] = []
    turns = -(-int(max(hi.max() - begin.min(), end.max() - lo.min())) // n)
    for shift in range(-turns * n, (turns + 1) * n, n):
        start = np.maximum(begin[owner] + shift, lo[taker])
        length = np.minimum(end[owner] + shift, hi[taker]) - start
        columns = [owner, taker, start - shift - begin[owner], start - lo[taker], length]
        pieces += np.stack(columns, axis=1)[length > 0].tolist()
    return sorted(pieces)


def _joined(pieces: list[slice]) -> list[slice]:
    """Return ranges in ascending order, with those that overlap or meet joined to one."""
    joined: list[slice] = []
    for piece in sorted(pieces, key=lambda rows: rows.start):
        if joined and piece.start <= joined[-1].stop:
            joined[-1] = slice(joined[-1].start, max(joined[-1].stop, piece.stop))
        else:
            joined.append(piece)
    return joined


_windows = lru_cache(maxsize=64)(Windows)


def _exchange(comm: Any, a: np.ndarray, give: Pieces, b: np.ndarray, take: Pieces) -> list[tuple]:
    """Send rows of a by rank; return [(rows of b, values that came for them)]. Collective."""
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
    """Return rows lo[rank] <= i < hi[rank] of a field as a new array, 0 where no rank owns them.
    Collective. a (..., own rows, m), on a ring of n rows.
    """
    bounds = np.asarray(starts)
    if comm.size == 1 and a.shape[-2] == (bounds[-1] if n is None else n):
        return np.take(a, np.arange(lo[0], hi[0]), axis=-2, mode="wrap")
    window = np.zeros((*a.shape[:-2], int(hi[comm.rank] - lo[comm.rank]), a.shape[-1]), a.dtype)
    rows = (tuple(np.asarray(ends).tolist()) for ends in (bounds, lo, hi))
    _windows(comm.rank, *rows, n).fill(comm, a, window)
    return window


def neighbours(
    comm: Any, a: np.ndarray, starts: np.ndarray, width: int, owned: ArrayLike | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Return the `width` rows before and after this rank's on the ring. Collective. owned: as
    `starts`, of the rows that exist; others are 0.
    """
    begin = np.asarray(starts)[:-1]
    end = np.asarray(starts)[1:]
    owned = starts if owned is None else owned
    n = int(starts[-1])
    before = rows_of(comm, a, owned, begin - width, begin, n)
    return before, rows_of(comm, a, owned, end, end + width, n)


def next_row(comm: Any, a: np.ndarray, starts: ArrayLike) -> np.ndarray:
    """Return the row (..., m) after those of this rank; row 0 after the last one. Collective."""
    end = np.asarray(starts)[1:]
    return rows_of(comm, a, starts, end, end + 1)[..., 0, :]
