"""Power spectra and autocorrelations of the fields of a contact, averaged over directions, by the
transforms of its grid.

With f_q = (1/N) sum_r f(r) exp(-i q.r), without the mean (q = 0):

    C(q) = L_x L_y <|f_q|^2>    averaged over the wave vectors in a ring
    A(r) = <f(x) f(x + r)>      averaged over x and the distances r in a ring (minimal image)

The variance of f is sum_q C(q)/(L_x L_y) = A(0).

Rings are RINGS to a factor of two, beginning at the longest wave and at the nearest neighbours; q
and r are means over their points. Along one axis alone (the other has one point) C is L <|f_q|^2>.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from ..parallel.grid import Grid

RINGS = 8


class Spectra:
    """pairs: FFT pairs taken so far, in those of the grid. All methods are collective.

    fields: rows i0 to i1 of each of "heights", "pressure" and "gap", in the program's units; units:
    of each in the scene's; add_heights: adds the spectrum of heights that are not stored.
    Transforms are those that the solve has planned, in the better precision of them; dtype: where
    it has none.
    """

    def __init__(
        self,
        grid: Grid,
        dtype: np.dtype,
        fields: dict[str, Callable[[int, int], np.ndarray]],
        units: dict[str, float],
        add_heights: Callable | None = None,
    ):
        self.grid, self.fields, self.units, self.add_heights = grid, fields, units, add_heights
        self.pairs = 0.0
        planned = self.grid.planned() or [self.grid.fft(dtype)]
        self.fft = max(planned, key=lambda fft: fft.dtype.itemsize)
        self._lengths = [size for size, n in zip(self.grid.sizes, self.grid.n) if n > 1] or [1.0]

    def power(self, name: str) -> dict[str, np.ndarray] | None:
        """Return the radial power spectrum of "heights", "pressure" or "gap": {"q": in 1/length,
        "power": C}; None on a grid of one point."""
        q_x, q_y = self.grid.q_x / self.grid.a, self.grid.q_y / self.grid.a
        longest = 2 * np.pi / max(self._lengths)
        weight = self.grid.multiplicity(np.arange(len(q_y)))
        scale = np.prod(self._lengths) * (self.fft.scale * self.units[name]) ** 2

        def sums(block: np.ndarray, m: int) -> np.ndarray:
            mine = slice(*self.fft.columns_of(m))
            q = np.hypot(q_x, q_y[mine, None])
            use = (q > 0) & (weight[mine, None] > 0)
            squares = scale * (
                block.real.astype(np.float64) ** 2 + block.imag.astype(np.float64) ** 2
            )
            return _ring_sums(
                q[use], longest, np.broadcast_to(weight[mine, None], q.shape)[use], squares[use]
            )

        q, power = self._means(self._columns(name, sums, backward=False))
        self.pairs += 0.5
        return {"q": q, "power": power} if len(q) else None

    def autocorrelation(self, name: str) -> dict[str, np.ndarray]:
        """Return the radial autocorrelation of "heights", "pressure" or "gap": {"r": distances, up
        to half of the cell, "correlation": A}."""

        def square(block: np.ndarray, m: int) -> None:
            block *= self.fft.dtype.type(self.fft.scale)
            block[...] = block.real**2 + block.imag**2
            if self.fft.columns_of(m)[0] == 0:
                block[0, 0] = 0

        self._columns(name, square, backward=True)
        self.pairs += 1.0
        x, y = (
            np.minimum(np.arange(n), n - np.arange(n)) * spacing
            for n, spacing in zip(self.grid.n, self.grid.spacings)
        )
        x = x[slice(*self.grid.rows)]
        nearest = min((a for a, n in zip(self.grid.spacings, self.grid.n) if n > 1), default=1.0)

        def sums(i0: int, i1: int, values: np.ndarray) -> np.ndarray:
            r = np.hypot(x[i0:i1, None], y)
            use = r <= min(self._lengths) / 2
            return _ring_sums(
                r[use], nearest, np.ones(np.count_nonzero(use)), values[: i1 - i0][use]
            )

        r, correlation = self._means(self.fft.backward_rows(sums))
        return {"r": r, "correlation": self.units[name] ** 2 * correlation}

    def _columns(self, name: str, apply: Callable[[np.ndarray, int], Any], backward: bool) -> list:
        """Transform a field, in the program's units, and call apply(block, m) on its columns;
        returns what that returned."""
        if name in self.fields:

            def fill(i0: int, i1: int, out: np.ndarray) -> None:
                out[: i1 - i0] = self.fields[name](i0, i1)

            self.fft.forward_rows(fill)
            return self.fft.columns(apply, backward=backward)
        assert self.add_heights is not None
        add = self.add_heights(self.fft)

        def added(block: np.ndarray, m: int) -> Any:
            add(block, m)
            return apply(block, m)

        return self.fft.columns(added, forward=False, backward=backward)

    def _means(self, parts: Sequence[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
        """Return means over the rings (distance, value) of what all blocks of all ranks summed up,
        without empty rings."""
        comm = self.grid.comm
        rings = int(comm.max([max((part.shape[1] for part in parts), default=0)])[0])
        total = np.zeros((3, rings))
        for part in parts:
            total[:, : part.shape[1]] += part
        counts, distances, values = comm.sum(total)
        filled = counts > 0
        return distances[filled] / counts[filled], values[filled] / counts[filled]


def _ring_sums(
    distance: np.ndarray, first: float, weight: np.ndarray, values: np.ndarray
) -> np.ndarray:
    """Return sums over the points in each ring of (weight, weight distance, weight value), (3,
    rings); ring 0 is distance 0."""
    with np.errstate(divide="ignore"):
        ring = np.maximum(1 + np.floor(RINGS * np.log2(distance / first) + 0.5), 0).astype(np.int64)
    return np.stack([np.bincount(ring, w) for w in (weight, weight * distance, weight * values)])
