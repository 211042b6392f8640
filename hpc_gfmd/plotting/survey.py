"""Passes over the fields of a load step, slab by slab: maps small enough to draw, and
distributions."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

SLAB_BYTES = 2**25
PER_DECADE = 100
_DECADES = (-12, 8)  # of the distributions, relative to their unit


@dataclass(frozen=True)
class Survey:
    """contact: share of each pixel that touches, or None; means: {name: pixel means}, those of
    pressure over the points that touch (0 where none does); largest: {name: largest value of a
    point}."""

    contact: np.ndarray | None
    means: dict
    largest: dict


def survey(fields: dict, pixels: int, window: tuple | None = None) -> Survey:
    """Look at the fields of one load step; pixels: at most so many along each axis; window: points
    (i0, i1, j0, j1), default: all."""
    i0, i1, j0, j1 = window or (
        0,
        next(iter(fields.values())).shape[0],
        0,
        next(iter(fields.values())).shape[1],
    )
    f_x, f_y = (max(1, -(-n // pixels)) for n in (i1 - i0, j1 - j0))
    parts: dict[str, list] = {}
    largest = dict.fromkeys(fields, -np.inf)
    for slab in _slabs(fields, i0, i1, f_x, slice(j0, j1)):
        touching = _touching(slab)
        if touching is not None:
            slab = (
                slab
                | {"contact": touching}
                | (
                    {"pressure": np.where(touching, slab["pressure"], 0)}
                    if "pressure" in slab
                    else {}
                )
            )
        for name, values in slab.items():
            parts.setdefault(name, []).append(_pixel_sums(values, f_x, f_y))
            if name in largest:
                largest[name] = max(largest[name], float(values.max()))
    sums: dict[str, Any] = {name: np.concatenate(blocks) for name, blocks in parts.items()}
    points = np.outer(np.diff([*range(i0, i1, f_x), i1]), np.diff([*range(j0, j1, f_y), j1]))
    count = sums.pop("contact", None)
    means = {
        name: total / (np.maximum(count, 1) if name == "pressure" else points)
        for name, total in sums.items()
    }
    return Survey(None if count is None else count / points, means, largest)


def density(fields: dict, name: str, unit: float) -> tuple[np.ndarray, np.ndarray]:
    """(edges, density) of "pressure" over the points that touch, or of "gap" over the others; it
    integrates to their share of the area.

    Logarithmic bins, PER_DECADE in a decade, without empty ones at the ends; unit: any magnitude of
    the values.
    """
    edges = unit * np.logspace(*_DECADES, (_DECADES[1] - _DECADES[0]) * PER_DECADE + 1)
    counts, shape = np.zeros(len(edges) - 1), fields[name].shape
    for slab in _slabs(fields, 0, shape[0], 1, slice(None)):
        touching = _touching(slab)
        counts += np.histogram(slab[name][touching if name == "pressure" else ~touching], edges)[0]
    filled = np.flatnonzero(counts)
    some = slice(filled[0], filled[-1] + 1) if len(filled) else slice(0, 0)
    edges = edges[some.start : some.stop + 1]
    return edges, counts[some] / np.diff(edges) / (shape[0] * shape[1])


def _slabs(fields: dict, i0: int, i1: int, multiple: int, columns: slice) -> Iterator[Any]:
    """Rows i0 <= i < i1 of all fields, a few at a time, a multiple of `multiple`."""
    shape = next(iter(fields.values())).shape
    rows = max(1, SLAB_BYTES // (8 * shape[1]) // multiple) * multiple
    for start in range(i0, i1, rows):
        stop = min(start + rows, i1)
        yield {
            name: np.asarray(field.read(start, stop), dtype=np.float64)[:, columns]
            for name, field in fields.items()
        }


def _touching(slab: dict) -> Any:
    return (
        slab["gap"] <= 0 if "gap" in slab else slab["pressure"] > 0 if "pressure" in slab else None
    )


def _pixel_sums(values: Any, f_x: int, f_y: int) -> np.ndarray:
    """Sums over blocks of f_x times f_y points; the last blocks may be smaller."""
    sums = np.add.reduceat(values.astype(np.float64), np.arange(0, values.shape[0], f_x), axis=0)
    return np.add.reduceat(sums, np.arange(0, values.shape[1], f_y), axis=1)
