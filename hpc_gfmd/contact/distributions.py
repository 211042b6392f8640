"""Distributions of pressure and gap: edges of bins, and densities, which integrate to 1.

Edges depend on powers of two and h_rms only: equal on any ranks, and bins of loads can be merged.
"""

from collections.abc import Callable
from math import floor, log2

import numpy as np

from .base import Arrays, Contact, Distribution

FINE = 7  # at most 2^FINE bins of pressure, more than half as many
NARROW = 2.0**-10  # relative: a distribution narrower than that gets no finer bins
GAP_OCTAVES = 20  # factors of two below h_rms; all smaller gaps are in the first bin
GAP_BINS = 4  # in a factor of two


def pressure(contact: Contact) -> Arrays | None:
    """Return edges, equally spaced by a power of two in units of E* g_rms, and density of pressures
    at points in contact; times a_r it is Persson's P(p), p > 0. Collective.
    """

    def values(i0: int, i1: int) -> np.ndarray:
        """Return the pressures at points in contact in some local rows."""
        touching = contact.touching(i0, i1)
        return contact.pressure_rows(i0, i1)[touching].astype(np.float64)

    low, high = _range(contact, values)
    if high < low:
        return None
    width = 2.0 ** (floor(log2(max(high - low, NARROW * high))) - FINE + 1)
    lowest_bin = floor(low / width)
    highest_bin = floor(high / width)

    def bins(i0: int, i1: int) -> np.ndarray:
        """Return the bin numbers of these pressures."""
        return (values(i0, i1) / width).astype(np.int64)

    counts = _counts(contact, bins, lowest_bin, highest_bin)
    edges = np.arange(lowest_bin, highest_bin + 2) * width * contact.pressure_unit
    return _density(edges, counts)


def gap(contact: Contact) -> Arrays | None:
    """Return edges, four a factor of two from 1e-6 h_rms (one bin below), and density of gaps at
    open points; times 1 - a_r it is P(g), g > 0. Collective.
    """
    surface = contact.surface
    if surface.h_rms == 0:
        return None
    unit = surface.height_unit / surface.h_rms
    lowest = -GAP_BINS * GAP_OCTAVES - 1

    def bins(i0: int, i1: int) -> np.ndarray:
        """Return the bin numbers of the finite gaps at open points in some local rows."""
        g = contact.gap_rows(i0, i1).astype(np.float64) * unit
        gaps = g[~contact.touching(i0, i1) & np.isfinite(g)]
        with np.errstate(divide="ignore"):
            return np.maximum(np.floor(GAP_BINS * np.log2(gaps)), lowest).astype(np.int64)

    _, top = _range(contact, bins)
    if top < lowest:
        return None
    edges = np.append(0.0, 2.0 ** (np.arange(lowest + 1, top + 2) / GAP_BINS)) * surface.h_rms
    return _density(edges, _counts(contact, bins, lowest, int(top)))


OfRows = Callable[[int, int], np.ndarray]


def _range(contact: Contact, values: OfRows) -> tuple[float, float]:
    """Return (lowest, highest) value over all ranks, (inf, -inf) without any. Collective."""
    grid = contact.grid

    def ends(i0: int, i1: int) -> tuple[float, float]:
        """Return (-lowest, highest) value of some local rows."""
        of_rows = values(i0, i1).astype(np.float64)
        return -of_rows.min(initial=np.inf), of_rows.max(initial=-np.inf)

    of_blocks = [(-np.inf, -np.inf), *grid.by_rows(ends, grid.inside[0])]
    low, high = grid.comm.max(np.max(of_blocks, axis=0))
    return -low, high


def _counts(contact: Contact, bins: OfRows, lowest: int, highest: int) -> np.ndarray:
    """Count the points of all ranks in bins, numbered by bins(i0, i1) of local rows. Collective."""
    grid = contact.grid
    zeros = np.zeros(highest - lowest + 1)

    def counts(i0: int, i1: int) -> np.ndarray:
        """Return the number of points per bin in some local rows."""
        return np.bincount(bins(i0, i1) - lowest, minlength=len(zeros))

    return grid.comm.sum(np.sum([zeros, *grid.by_rows(counts, grid.inside[0])], axis=0))


def _density(edges: np.ndarray, counts: np.ndarray) -> Arrays:
    """Return {"edges", "density"} of a histogram, without empty bins at both ends."""
    filled = np.nonzero(counts)[0]
    start = filled[0]
    stop = filled[-1] + 1
    edges = edges[start : stop + 1]
    return {"edges": edges, "density": counts[start:stop] / counts.sum() / np.diff(edges)}


DISTRIBUTIONS = {
    "pressure": Distribution(
        pressure,
        "distribution of the pressure at points that touch: share of them per pressure",
        {"edges": "pressure", "density": "1/pressure"},
    ),
    "gap": Distribution(
        gap,
        "distribution of the gap at points that do not touch: share of them per gap",
        {"edges": "length", "density": "1/length"},
    ),
}
