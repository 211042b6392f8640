"""The quantities that a load is searched for by: how each goes with the load, and what is known of
it before, in the course of the iterations and in the end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, isfinite, log, prod
from typing import TYPE_CHECKING

from .area_search import AreaSearch
from .height_statistics import HeightStatistics
from .load_search import CALIBRATION, Errors, SecantSearch, Value

if TYPE_CHECKING:
    from ..certificate.certificate import Certificate
    from ..solvers.base import Progress, Solver
    from ..surface import Surface
    from .load import Load


class GapSearch(SecantSearch):
    """A search for a mean gap."""

    usual = 0.4

    def guess(self, surface: Surface) -> float:
        """Guess as of self-affine walls, or where one point carries all."""
        alone = (self.heights.top - self.target) / (surface.grid.a * self.heights.points)
        return max(-1 - 2 * self.target * surface.slope / surface.h_rms, log(alone))

    def straight(self, y: float) -> float:
        """Use that the mean gap decreases like exp(-c p0^s)."""
        if y <= 0:
            return inf
        return log(log(self.heights.top / y)) if y < self.heights.top else -inf

    def predicted(self, solver: Solver, progress: Progress, errors: Errors) -> Value | None:
        """Predict the mean gap: as uncertain as it is, or as the pressure where nothing is open
        yet."""
        error = max(errors) if progress.contact == solver.N else errors[0]
        return (progress.predicted[1] * solver.grid.a, error) if progress.predicted else None

    def within(self, solver: Solver, progress: Progress, room: float) -> bool:
        """Compare the estimated error of the mean gap."""
        estimate = progress.estimate
        if estimate is None:
            return True
        return estimate.gap < room or estimate.attainable[0] >= self.tolerance

    def certified(self, solver: Solver, certificate: Certificate) -> Value:
        """Return the mean gap of the certificate, without an error where no iteration makes that
        smaller."""
        is_limited = certificate.attainable[0] >= self.tolerance
        error = 0.0 if is_limited else certificate.errors[1]
        return certificate.gap_mean * solver.grid.a, error


@dataclass
class OpeningSearch(GapSearch):
    """A search for a mean gap next to full contact, which is a power of p0/(closes_at - p0).

    `begin_below` begins it, once the load of full contact is known.

    Attributes
    ----------
    opens : float
        By how much p0 is below `closes_at` where a single point is open.
    """

    usual = 1.5
    from_full_contact = True

    opens: float = 0.0

    def begin_below(self, closes_at: float) -> None:
        """Start below the load of full contact, closes_at, where a single point is open."""
        self.closes_at = closes_at
        self.x = log(closes_at) + log(max(closes_at / self.opens - 1, 1.0))

    def straight(self, y: float) -> float:
        """Take the logarithm of that power."""
        return log(self.heights.top / y) if y > 0 else inf


class ApproachSearch(SecantSearch):
    """A search for an approach."""

    usual = 0.8

    def guess(self, surface: Surface) -> float:
        """Guess as of a punch as large as the surface."""
        return log(self.target / max(surface.sizes))

    def straight(self, y: float) -> float:
        """Use that the approach is a power of the load."""
        return log(y) if y > 0 else -inf

    def predicted(self, solver: Solver, progress: Progress, errors: Errors) -> Value | None:
        """Predict the approach by the displacement as it is."""
        grid = solver.grid
        heights = self.heights
        share = grid.N / grid.cell_points
        (total_gap,) = grid.comm.sum([solver.g.sum(dtype=float)])
        uniform = solver.p_cell / solver.elastic.multipliers.uniform
        y = (uniform - total_gap / grid.cell_points) * grid.a
        y += heights.top * share - heights.lowest * (1 - share)
        return y, _error_of_approach(y, progress.gap_mean * grid.a, *errors)

    def within(self, solver: Solver, progress: Progress, room: float) -> bool:
        """Compare the error of what is predicted."""
        prediction = self._prediction(solver, progress)
        return prediction is None or prediction[1] < room

    def certified(self, solver: Solver, certificate: Certificate) -> Value:
        """Return the approach of the certificate."""
        a = solver.grid.a
        y = certificate.approach * a
        return y, _error_of_approach(y, certificate.gap_mean * a, *certificate.errors[1:])


def _error_of_approach(y: float, gap: float, gap_error: float, pressure_error: float) -> float:
    """Return the relative error of an approach y at a mean gap.

    gap_error, pressure_error: relative, of the mean gap and of the pressure field.
    """
    return gap_error * gap / y + CALIBRATION.field * pressure_error if y > 0 else inf


SEARCHES: dict[str, type[SecantSearch]] = {
    "a_r": AreaSearch,
    "gap_mean": GapSearch,
    "approach": ApproachSearch,
}


def search_for(
    load: Load,
    surface: Surface,
    heights: HeightStatistics,
    tolerance: float,
    error_counts: bool,
    history: Sequence[dict[str, float]] = (),
    hardness: float | None = None,
) -> SecantSearch:
    """Begin the search for the load that gives an area, a mean gap or an approach.

    Parameters
    ----------
    load : Load
        What is asked for.
    surface : Surface
        The surface.
    heights : HeightStatistics
        Of the surface.
    tolerance : float
        Relative, of what is asked for.
    error_counts : bool
        Whether the error of the solution counts towards the tolerance.
    history : sequence of dict
        Loads that were solved before: `p0`, in the program's unit, and what each gave, by quantity.
    hardness : float, optional
        The largest pressure, in the program's unit.

    Returns
    -------
    SecantSearch
        At its first load.
    """
    value = load.value if load.quantity == "a_r" else load.value / surface.slope
    kind = SEARCHES[load.quantity]
    search = kind(
        value,
        tolerance,
        error_counts,
        heights,
        heights,
        closes_at=hardness or inf,
        slope=kind.usual,
    )
    if isinstance(search, AreaSearch):
        search.map_points = prod(surface.n) // prod(surface.grid.nominal)
    for solved in history:
        search.x = search.x_of(solved["p0"])
        if isfinite(search.x):
            search.secant(solved[load.quantity])
    if search.certified_before is None:
        search.x = search.guess(surface)
        return search
    x, f = search.certified_before
    way = search.straight(search.aim) - f
    if abs(way) > 4 * CALIBRATION.step * search.slope:  # what is near tells nothing of it
        search.slope = kind.usual
    search.x = x + way / search.slope
    return search
