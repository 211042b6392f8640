"""Error of the mean gap by the grid: what a contact has on coarser grids tells how much finer ones
change it.

The estimate is the difference from the contact on every second point, or half of that on every
fourth, if larger, as one difference may vanish by chance; cautious, since most errors fall with the
square of the spacing. Both may vanish where the error falls with the spacing itself, at free edges
and on profiles, so that these have a least error, too. docs/accuracy.md has the measurements.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import exp, inf, log, sqrt
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..contact.edges import reaches_free_edges
from ..parallel.threads import added
from ..theory.steepness import gap_by_pressure

if TYPE_CHECKING:
    from ..contact.contact import Contact
    from ..solvers.base import Solver

# Least error of the mean gap over g_rms times the spacing, of contacts that reach a free edge (of
# profiles: that have one) and of profiles. Measured on 3,046 pieces of 24 to 64 points a side and
# 1,653 profiles: half of the errors are below 0.05 and 0.005, 1 in 100 above 0.28 and 0.08. Beyond
# the estimate are 2 and 8, by up to 1.8 times; without a least error 50 and 31 were, by up to 38
# times. Of 735 profiles with free edges, of 8 to 128 points, 5 are, by up to 1.4 times.
AT_FREE_EDGES = 0.2
OF_PROFILES = 0.05
# Way, in a logarithm, from another grid's point beyond which that tells nothing. Chosen.
TOO_FAR = 5.0


class CoarseContact(NamedTuple):
    """Mean pressure and mean gap of a coarser grid, in units of the finer one."""

    p0: float
    gap_mean: float


def coarser_contacts(
    solver: Solver, coarser: Sequence[CoarseContact], scale: float
) -> list[CoarseContact]:
    """Return the solver's state (dents as a gap of 0) and those of coarser grids, in the unit of a
    grid whose spacing is 1/scale of the solver's. Collective.
    """
    state = solver.state
    grid = state.grid
    rows, points = grid.inside

    def gap_of_rows(i0: int, i1: int) -> tuple[float]:
        gap = np.maximum(state.g[i0:i1, :points], 0).sum(dtype=np.float64)
        return (float(gap),)

    (gap,) = grid.comm.sum(added(grid.by_rows(gap_of_rows, rows), 1))
    present = CoarseContact(float(state.p0), float(gap) / grid.N)
    return [contact._replace(gap_mean=contact.gap_mean * scale) for contact in (present, *coarser)]


def gap_discretisation(
    contact: Contact, coarser: Sequence[CoarseContact], holds_gap: bool = False
) -> float | None:
    """Return the relative error of the mean gap by the grid, None where nothing touches; holds_gap:
    that of the pressure at a prescribed gap. Coarser grids may have missed what is prescribed.
    """
    p0 = contact.p_mean / contact.pressure_unit
    gap = contact.certificate.gap_mean
    if not (coarser and contact.contact_points > 0 and p0 > 0 and gap > 0):
        return None
    least_error = _least_error(contact) / gap
    ratios = [(coarse.p0 / p0, coarse.gap_mean / gap) for coarse in coarser[:2]]
    gap_over_h_rms = contact.gap_mean / contact.h_rms
    if holds_gap:
        least_error /= gap_by_pressure(gap_over_h_rms)
    changes = [_change(*of_both, gap_over_h_rms, holds_gap) for of_both in ratios]
    return max(least_error, *(change / 2**k for k, change in enumerate(changes)))


def _least_error(contact: Contact) -> float:
    """Return the least error of the mean gap, in the program's unit."""
    grid = contact.grid
    spacing = max(a for n, a in zip(grid.nominal, grid.spacings) if n > 1) / grid.a
    is_profile = 1 in grid.nominal
    if (is_profile and grid.padded) or reaches_free_edges(contact):
        return AT_FREE_EDGES * spacing
    return OF_PROFILES * spacing if is_profile else 0.0


def _change(of_pressure: float, of_gap: float, gap_over_h_rms: float, holds_gap: bool) -> float:
    """Return the relative change of the gap at the same pressure, or (holds_gap) of the pressure at
    the same gap, from another grid's ratios of both: along the curve between both points, of whose
    way half may be wrong, inf if it is TOO_FAR. of_gap: 0 where the other grid is closed.
    """
    if of_gap <= 0:
        return abs(of_pressure - 1) if holds_gap else 1.0
    steepness = gap_by_pressure(gap_over_h_rms * sqrt(of_gap))
    if holds_gap:
        ratio = of_pressure
        way = log(of_gap) / steepness
    else:
        ratio = of_gap
        way = log(of_pressure) * steepness
    return inf if abs(way) > TOO_FAR else abs(ratio * exp(way) - 1) + 0.5 * abs(way)
