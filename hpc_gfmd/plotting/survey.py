"""Passes over the fields of a load step, a few rows at a time: small maps, and distributions."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

SLAB_BYTES = 2**25
YIELD_ROUNDING = 1e-5  # relative, of a pressure that is the hardness, in single precision
BINS = 48  # of pressure
GAP_DECADES = 6  # of the gap, below the largest one
PER_DECADE = 10  # bins of the gap


@dataclass(frozen=True)
class Survey:
    """Fields of a load step, reduced to pixels.

    Attributes
    ----------
    means : dict of str to ndarray, shape (pixels along x, along y)
        Mean of each field over each pixel; of the pressure, the mean over touching points (0 if
        there are none). "contact": share of points that touch, if pressure or gap are known.
        "yielded": share of the touching points whose pressure is the hardness, if there is one.
    largest : dict of str to float
        Largest value of a point, by field.
    """

    means: dict[str, np.ndarray]
    largest: dict[str, float]


def survey(
    fields: dict, pixels: int, window: tuple | None = None, hardness: float | None = None
) -> Survey:
    """Reduce the fields of one load step to pixels, reading a few rows at a time.

    Parameters
    ----------
    fields : dict of str to field
        By name; each has a `shape` and `read(start, stop)`.
    pixels : int
        Largest number of pixels along each axis.
    window : (i0, i1, j0, j1), optional
        Points i0 <= i < i1, j0 <= j < j1; default: all.
    hardness : float, optional
        Pressure at which the solid yields, in the unit of the pressure.

    Returns
    -------
    Survey
    """
    shape = next(iter(fields.values())).shape
    i0, i1, j0, j1 = window or (0, shape[0], 0, shape[1])
    f_x, f_y = (max(1, -(-n // pixels)) for n in (i1 - i0, j1 - j0))
    parts: dict[str, list] = {}
    largest: dict[str, float] = {}
    for slab in _slabs(fields, i0, i1, f_x, slice(j0, j1)):
        if hardness is not None and "pressure" in slab:
            slab["yielded"] = slab["pressure"] >= hardness * (1 - YIELD_ROUNDING)
        for name, values in slab.items():
            in_contact = name in ("pressure", "yielded")
            counted = slab["contact"] if in_contact else np.ones(values.shape)
            values = values * counted
            total = _pixel_sums(values, f_x, f_y)
            points = _pixel_sums(counted, f_x, f_y)
            parts.setdefault(name, []).append(total / np.maximum(points, 1))
            largest[name] = max(largest.get(name, -np.inf), float(values.max()))
    return Survey({name: np.concatenate(blocks) for name, blocks in parts.items()}, largest)


def histogram(fields: dict, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Compute a histogram of pressure or gap, reading the fields twice, a few rows at a time.

    Parameters
    ----------
    fields : dict of str to field
        Fields of a load step, as for `survey`.
    name : {"pressure", "gap"}
        "pressure": at points that touch, in even bins from 0. "gap": at all other points, in
        logarithmic bins, the first of which reaches down to 0.

    Returns
    -------
    edges : ndarray, shape (k + 1,)
    shares : ndarray, shape (k,)
        Points in each bin over all points.
    """
    n_x, n_y = fields[name].shape

    def values() -> Iterator[np.ndarray]:
        for slab in _slabs(fields, 0, n_x, 1, slice(None)):
            touching = slab["contact"]
            yield slab[name][touching if name == "pressure" else ~touching]

    top = max(block.max(initial=0.0) for block in values()) or 1.0
    edges = np.linspace(0, top, BINS + 1)
    if name == "gap":
        edges = np.append(
            0.0, np.geomspace(top / 10**GAP_DECADES, top, GAP_DECADES * PER_DECADE + 1)
        )
    return edges, sum(np.histogram(block, edges)[0] for block in values()) / (n_x * n_y)


def _slabs(fields: dict, i0: int, i1: int, multiple: int, columns: slice) -> Iterator[Any]:
    """Yield {field: its rows of a slab, float64} for the rows i0 <= i < i1, slab by slab.

    Slabs have a multiple of `multiple` rows, but for the last one. "contact" is added if gap or
    pressure are there: True where points touch.
    """
    shape = next(iter(fields.values())).shape
    rows = max(1, SLAB_BYTES // (8 * shape[1]) // multiple) * multiple
    for start in range(i0, i1, rows):
        stop = min(start + rows, i1)
        slab: dict[str, np.ndarray] = {
            name: np.asarray(field.read(start, stop), dtype=np.float64)[:, columns]
            for name, field in fields.items()
        }
        if "gap" in slab:
            slab["contact"] = slab["gap"] <= 0
        elif "pressure" in slab:
            slab["contact"] = slab["pressure"] > 0
        yield slab


def _pixel_sums(values: Any, f_x: int, f_y: int) -> np.ndarray:
    """Return sums over blocks of f_x times f_y points; the last blocks may be smaller."""
    sums = np.add.reduceat(values.astype(np.float64), np.arange(0, values.shape[0], f_x), axis=0)
    return np.add.reduceat(sums, np.arange(0, values.shape[1], f_y), axis=1)
