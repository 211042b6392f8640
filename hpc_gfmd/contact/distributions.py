"""Distributions of pressure and gap: edges of bins, and the density in them, which integrates to 1.

The bins follow from the numbers 2^k and h_rms, so that they are the same on any number of ranks,
and those of other loads are joined or split to be compared. Rows of the fields are looked at a few
at a time.
"""

from __future__ import annotations

from collections.abc import Callable
from math import floor, log2
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from .base import Arrays, Distribution

if TYPE_CHECKING:
    from .contact import Contact

FINE = 7  # at most 2^FINE bins of pressure, more than half as many
NARROW = 2.0**-10  # relative: a distribution narrower than that gets no finer bins
# below h_rms, all smaller gaps being in the first bin; bins in a factor of two
GAP_OCTAVES, GAP_BINS = 20, 4


def pressure(contact: Contact) -> Arrays | None:
    """Of the points that touch: a_r times it is Persson's P(p) at p > 0. Linear bins, their width a
    power of two in units of E* g_rms.

    edges: pressures; density: per pressure. None where nothing touches.
    """
    comm = contact.surface.grid.comm

    def rows(i0: int, i1: int) -> np.ndarray:
        touching = contact.touching(i0, i1)
        return contact.pressure_rows(slice(i0, i1))[touching].astype(np.float64)

    high, low = comm.max(
        _over_rows(
            contact,
            lambda i0, i1: [rows(i0, i1).max(initial=-np.inf), -rows(i0, i1).min(initial=np.inf)],
            np.maximum,
            [-np.inf, -np.inf],
        )
    ) * (1, -1)
    if high < low:
        return None
    width = 2.0 ** (floor(log2(max(high - low, NARROW * high))) - FINE + 1)
    first, last = floor(low / width), floor(high / width)

    def counts(i0: int, i1: int) -> np.ndarray:
        return np.bincount(
            (rows(i0, i1) / width).astype(np.int64) - first, minlength=last - first + 1
        )

    return _density(
        np.arange(first, last + 2) * width * contact.pressure_unit,
        comm.sum(_over_rows(contact, counts, np.add, np.zeros(last - first + 1))),
    )


def gap(contact: Contact) -> Arrays | None:
    """Of the points that do not touch: 1 - a_r times it is P(g) at g > 0. Four bins in a factor of
    two, from h_rms down to 1e-6 h_rms.

    edges: gaps; density: per gap. None where all points touch.
    """
    comm, surface, (_, points) = (
        contact.surface.grid.comm,
        contact.surface,
        contact.surface.grid.inside,
    )
    if surface.h_rms == 0:
        return None
    unit, lowest = surface.height_unit / surface.h_rms, -GAP_BINS * GAP_OCTAVES - 1

    def bins(i0: int, i1: int) -> np.ndarray:
        gaps = contact.g[i0:i1, :points][~contact.touching(i0, i1)].astype(np.float64) * unit
        with np.errstate(divide="ignore"):
            return np.maximum(np.floor(GAP_BINS * np.log2(gaps)), lowest).astype(np.int64)

    top = int(
        comm.max(
            _over_rows(
                contact,
                lambda i0, i1: [bins(i0, i1).max(initial=lowest - 1)],
                np.maximum,
                [lowest - 1],
            )
        )[0]
    )
    if top < lowest:
        return None

    def counts(i0: int, i1: int) -> np.ndarray:
        return np.bincount(bins(i0, i1) - lowest, minlength=top - lowest + 1)

    edges = np.append(0.0, 2.0 ** (np.arange(lowest + 1, top + 2) / GAP_BINS)) * surface.h_rms
    return _density(
        edges, comm.sum(_over_rows(contact, counts, np.add, np.zeros(top - lowest + 1)))
    )


def _over_rows(
    contact: Contact, of_rows: Callable[[int, int], ArrayLike], join: np.ufunc, start: ArrayLike
) -> np.ndarray:
    """join(..., of_rows(i0, i1)) over this rank's rows."""
    grid = contact.surface.grid
    found = [start, *grid.by_rows(of_rows, grid.inside[0])]
    return join.reduce(np.array(found, dtype=np.float64))


def _density(edges: np.ndarray, counts: np.ndarray) -> Arrays:
    filled = np.nonzero(counts)[0]
    some = slice(filled[0], filled[-1] + 1)
    edges = edges[some.start : some.stop + 1]
    return {"edges": edges, "density": counts[some] / counts.sum() / np.diff(edges)}


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
