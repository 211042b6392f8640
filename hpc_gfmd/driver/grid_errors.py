"""Errors by the grid: what a contact has on coarser grids tells how much finer ones change it.

The estimate is the difference from the contact on every second point, or half of that on every
fourth, if larger, as one difference may vanish by chance; cautious, since most errors fall with the
square of the spacing. The largest pressure, of a single point, is more random: two more grids
count, and the result twice. docs/accuracy.md has the measurements.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..contact.contact import GridErrors
from ..contact.pressure import contact_pressure_max

if TYPE_CHECKING:
    from ..contact.contact import Contact
    from ..solvers.base import Solver


class CoarseContact(NamedTuple):
    """Mean pressure, mean gap and largest pressure of a coarser grid, in units of the finer one."""

    p0: float
    gap_mean: float
    pressure_max: float


def coarser_contacts(
    solver: Solver, coarser: Sequence[CoarseContact], scale: float
) -> list[CoarseContact]:
    """Return the solver's state (dents as a gap of 0) and those of coarser grids, in the unit of a
    grid whose spacing is 1/scale of the solver's. Collective.
    """
    state = solver.state
    grid = state.grid
    rows, points = grid.inside

    def of_rows(i0: int, i1: int) -> tuple[float, float]:
        """Return the sum of the gap and the largest pressure."""
        gap = np.maximum(state.g[i0:i1, :points], 0).sum(dtype=np.float64)
        return float(gap), float(state.p[i0:i1, :points].max(initial=0.0))

    parts = grid.by_rows(of_rows, rows)
    (gap,) = grid.comm.sum([sum(part[0] for part in parts)])
    (largest,) = grid.comm.max([max((part[1] for part in parts), default=0.0)])
    present = CoarseContact(float(state.p0), float(gap) / grid.N, float(largest))
    return [contact._replace(gap_mean=contact.gap_mean * scale) for contact in (present, *coarser)]


def grid_errors(contact: Contact, coarser: Sequence[CoarseContact]) -> GridErrors | None:
    """Return the errors by the grid, None where nothing touches; a prescribed area or gap adds the
    change of the mean pressure. Collective.
    """
    largest = contact_pressure_max(contact) / contact.pressure_unit
    p0 = contact.p_mean / contact.pressure_unit
    gap = contact.certificate.gap_mean
    if not (coarser and largest > 0 and p0 > 0 and gap > 0):
        return None

    def worst(name: str, value: float, levels: int) -> float:
        """Return the largest difference from coarser grids, over 2 for each further halving."""
        return max(
            (abs(getattr(coarse, name) / value - 1) + abs(coarse.p0 / p0 - 1)) / 2**k
            for k, coarse in enumerate(coarser[:levels])
        )

    return GridErrors(worst("gap_mean", gap, 2), 2 * worst("pressure_max", largest, 4))
