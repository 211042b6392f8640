"""Power spectra and autocorrelations of heights, pressure and gap, averaged over directions.

With f_q = (1/N) sum_r f(r) exp(-i q.r), without the mean (q = 0):

    C(q) = L_x L_y <|f_q|^2>    averaged over the wave vectors in a ring
    A(r) = <f(x) f(x + r)>      averaged over x and the distances r in a ring (minimal image)

There are RINGS rings per factor of two; q and r are means over their points. For a surface that
varies along one axis only, C is the spectrum of a line times the length of the other axis.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from .base import Arrays, Contact, Distribution

if TYPE_CHECKING:  # names of distributions need no kernels
    from ..parallel.fft import SlabFFT
    from ..parallel.grid import Grid

RINGS = 8
FIELDS = {"heights": "length", "pressure": "pressure", "gap": "length"}


def power(name: str, contact: Contact) -> Arrays | None:
    """Return "q" and "power" C(q) of one of FIELDS, or None; half an FFT pair. Collective."""
    grid = contact.grid
    fft = _transforms(contact)
    q_x = grid.q_x / grid.a
    q_y = grid.q_y / grid.a
    longest = 2 * np.pi / max(_lengths(grid))
    weight = grid.multiplicity(np.arange(len(q_y)))
    scale = np.prod(grid.sizes) * (fft.scale * _unit(contact, name)) ** 2

    def sums(block: np.ndarray, m: int) -> np.ndarray:
        """Return the ring sums of |f_q|^2 in a block of columns."""
        mine = slice(*fft.columns_of(m))
        q = np.hypot(q_x, q_y[mine, None])
        use = (q > 0) & (weight[mine, None] > 0)
        squares = scale * (block.real.astype(np.float64) ** 2 + block.imag.astype(np.float64) ** 2)
        return _ring_sums(
            q[use], longest, np.broadcast_to(weight[mine, None], q.shape)[use], squares[use]
        )

    q, power = _means(grid, _columns(contact, name, fft, sums, backward=False))
    contact.asked_pairs.append(0.5)
    return {"q": q, "power": power} if len(q) else None


def autocorrelation(name: str, contact: Contact) -> Arrays:
    """Return "r", up to half the shorter side, and "correlation"; an FFT pair. Collective."""
    grid = contact.grid
    fft = _transforms(contact)

    def square(block: np.ndarray, m: int) -> None:
        """Replace a block of columns by its |f_q|^2, with 0 at q = 0."""
        block *= fft.dtype.type(fft.scale)
        block[...] = block.real**2 + block.imag**2
        if fft.columns_of(m)[0] == 0:
            block[0, 0] = 0

    _columns(contact, name, fft, square, backward=True)
    contact.asked_pairs.append(1.0)
    x, y = (
        np.minimum(np.arange(n), n - np.arange(n)) * spacing
        for n, spacing in zip(grid.n, grid.spacings)
    )
    x = x[slice(*grid.rows)]
    nearest = min((a for a, n in zip(grid.spacings, grid.n) if n > 1), default=1.0)

    def sums(i0: int, i1: int, values: np.ndarray) -> np.ndarray:
        """Return the ring sums of A(r) in some local rows."""
        r = np.hypot(x[i0:i1, None], y)
        use = r <= min(_lengths(grid)) / 2
        return _ring_sums(r[use], nearest, np.ones(np.count_nonzero(use)), values[: i1 - i0][use])

    r, correlation = _means(grid, fft.backward_rows(sums))
    return {"r": r, "correlation": _unit(contact, name) ** 2 * correlation}


def _transforms(contact: Contact) -> SlabFFT:
    """Return transforms planned for the contact's grid, double precision first, or plan them."""
    grid = contact.grid
    planned = grid.planned() or [grid.fft(contact.g.dtype)]
    return max(planned, key=lambda fft: fft.dtype.itemsize)


def _lengths(grid: Grid) -> list[float]:
    """Return the lengths of the cell along axes of more than one point, [1.0] if there are none."""
    return [size for size, n in zip(grid.sizes, grid.n) if n > 1] or [1.0]


def _unit(contact: Contact, name: str) -> float:
    """Return the size of the program's unit of a field (one of FIELDS), in the scene's unit."""
    return contact.pressure_unit if name == "pressure" else contact.surface.height_unit


def _columns(
    contact: Contact,
    name: str,
    fft: SlabFFT,
    apply: Callable[[np.ndarray, int], Any],
    backward: bool,
) -> list:
    """Transform a field (program's units) and return apply(block, m) of this rank's columns, which
    it may change; heights may have either sign. Collective. With `backward` rows are ready to go
    back.
    """
    h: Any = contact.surface.h
    if name == "heights" and h is None:
        assert contact.surface.add_spectrum is not None
        add = contact.surface.add_spectrum(fft)

        def added(block: np.ndarray, m: int) -> Any:
            """Add the generated heights to a block of zeros, and apply."""
            add(block, m)
            return apply(block, m)

        return fft.columns(added, forward=False, backward=backward)
    rows = {"pressure": contact.pressure_rows, "gap": contact.gap_rows}

    def fill(i0: int, i1: int, out: np.ndarray) -> None:
        """Write some local rows of the field to `out`."""
        out[: i1 - i0] = rows[name](i0, i1) if name in rows else h[i0:i1]

    fft.forward_rows(fill)
    return fft.columns(apply, backward=backward)


def _means(grid: Grid, parts: Sequence[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Return (mean distance, mean value) over the rings that are not empty. Collective."""
    rings = int(grid.comm.max([max((part.shape[1] for part in parts), default=0)])[0])
    total = np.zeros((3, rings))
    for part in parts:
        total[:, : part.shape[1]] += part
    counts, distances, values = grid.comm.sum(total)
    filled = counts > 0
    return distances[filled] / counts[filled], values[filled] / counts[filled]


def _ring_sums(
    distance: np.ndarray, innermost: float, weight: np.ndarray, values: np.ndarray
) -> np.ndarray:
    """Return sums (3, rings) of weight, times distance, times value; ring 0 is distance 0."""
    with np.errstate(divide="ignore"):
        ring = np.maximum(1 + np.floor(RINGS * np.log2(distance / innermost) + 0.5), 0).astype(
            np.int64
        )
    return np.stack([np.bincount(ring, w) for w in (weight, weight * distance, weight * values)])


DISTRIBUTIONS = {
    f"{name}_spectrum": Distribution(
        partial(power, name),
        f"radial power spectrum of the {name}: L_x L_y <|f_q|^2>, over the wave number",
        {"q": "1/length", "power": f"{unit}^2 length^2"},
        periodic=True,
    )
    for name, unit in FIELDS.items()
} | {
    f"{name}_autocorrelation": Distribution(
        partial(autocorrelation, name),
        f"radial autocorrelation of the {name}, without their mean, over the distance",
        {"r": "length", "correlation": f"{unit}^2"},
        periodic=True,
    )
    for name, unit in FIELDS.items()
}
