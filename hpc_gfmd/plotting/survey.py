"""One pass over the fields of a load step, slab by slab: maps small enough to draw, and distributions."""

from dataclasses import dataclass

import numpy as np

MAX_PIXELS = 1024  # per side of a map
SLAB_BYTES = 2**25
PER_DECADE = 10
_DECADES = (-12, 8)  # of the distributions, relative to their unit


@dataclass(frozen=True)
class Survey:
    """contact: share of each pixel that touches; pressure, gap: pixel means, or None if not in the file.

    The densities are pairs (x, density) on a logarithmic grid: of the pressure in the contact, of the gap
    outside. They integrate to a_r and 1 - a_r. Pressures and gaps are in the units handed to `survey`.
    """

    contact: np.ndarray
    pressure: np.ndarray | None
    gap: np.ndarray | None
    pressure_density: tuple | None
    gap_density: tuple | None


def survey(fields: dict, p_unit: float, gap_unit: float) -> Survey:
    """Read the stored fields "pressure" and "gap" of one load step; at least one of them must be there."""
    units = {name: unit for name, unit in (("pressure", p_unit), ("gap", gap_unit)) if name in fields}
    shape = fields[next(iter(units))].shape
    f_x, f_y = (-(-n // MAX_PIXELS) for n in shape)
    rows = max(1, SLAB_BYTES // (8 * shape[1]) // f_x) * f_x
    edges = np.logspace(*_DECADES, (_DECADES[1] - _DECADES[0]) * PER_DECADE + 1)
    maps = {"contact": [], **{name: [] for name in units}}
    counts = {name: np.zeros(len(edges) - 1) for name in units}
    for parts in zip(*(fields[name].pieces(at_once=rows) for name in units), strict=True):
        slab = {name: part / unit for (name, unit), (_, part) in zip(units.items(), parts, strict=True)}
        contact = slab["gap"] <= 0 if "gap" in slab else slab["pressure"] > 0
        where = {"pressure": contact, "gap": ~contact}
        for name, values in slab.items():
            counts[name] += np.histogram(values[where[name]], edges)[0]
        for name, values in (slab | {"contact": contact}).items():
            maps[name].append(_pixel_means(values, f_x, f_y))
    maps = {name: np.concatenate(parts) for name, parts in maps.items()}
    densities = {name: _density(edges, count, shape[0] * shape[1]) for name, count in counts.items()}
    pressure, gap = ((maps.get(name), densities.get(name)) for name in ("pressure", "gap"))
    return Survey(maps["contact"], pressure[0], gap[0], pressure[1], gap[1])


def _pixel_means(values, f_x, f_y):
    """Means over blocks of f_x times f_y points; the last blocks may be smaller."""
    sums = np.add.reduceat(values.astype(np.float64), np.arange(0, values.shape[0], f_x), axis=0)
    sums = np.add.reduceat(sums, np.arange(0, values.shape[1], f_y), axis=1)
    height = np.diff([*range(0, values.shape[0], f_x), values.shape[0]])
    width = np.diff([*range(0, values.shape[1], f_y), values.shape[1]])
    return sums / np.outer(height, width)


def _density(edges, counts, points):
    """Density per unit of x at the geometric centres of the bins that hold anything."""
    filled = counts > 0
    centres = np.sqrt(edges[1:] * edges[:-1])
    return centres[filled], (counts / np.diff(edges) / points)[filled]
