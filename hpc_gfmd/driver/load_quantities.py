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

Known = tuple[float, bool, HeightStatistics]


class GapSearch(SecantSearch):
    """For a mean gap."""

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
        found = progress.estimate
        return not found or found.gap < room or found.attainable[0] >= self.tolerance

    def certified(self, solver: Solver, certificate: Certificate) -> Value:
        """Give the mean gap of the certificate."""
        limited = certificate.attainable[0] >= self.tolerance  # no iteration helps
        error = 0.0 if limited else certificate.errors[1]
        return certificate.gap_mean * solver.grid.a, error


@dataclass
class OpeningSearch(GapSearch):
    """For a mean gap next to full contact: a power of p0/(closes_at - p0)."""

    usual, from_full_contact = 1.5, True

    opens: float = 0.0  # p0 that a single open point takes, below closes_at

    @classmethod
    def of(cls, target: float, opens: float, known: Known) -> OpeningSearch:
        """Return a search that `begin_below` begins, once the load of full contact is known."""
        return cls(target, *known, known[-1], slope=cls.usual, opens=opens)

    def begin_below(self, closes_at: float) -> None:
        """Start below the load of full contact, closes_at, where a single point is open."""
        self.closes_at = closes_at
        self.x = log(closes_at) + log(max(closes_at / self.opens - 1, 1.0))

    def straight(self, y: float) -> float:
        """Take the logarithm of that power."""
        return log(self.heights.top / y) if y > 0 else inf


class ApproachSearch(SecantSearch):
    """For an approach."""

    usual = 0.8

    def guess(self, surface: Surface) -> float:
        """Guess as of a punch as large as the surface."""
        return log(self.target / max(surface.sizes))

    def straight(self, y: float) -> float:
        """Use that the approach is a power of the load."""
        return log(y) if y > 0 else -inf

    def predicted(self, solver: Solver, progress: Progress, errors: Errors) -> Value | None:
        """Predict the approach by the displacement as it is."""
        grid, heights = solver.grid, self.heights
        share, mean = grid.N / grid.cell_points, grid.comm.sum([solver.g.sum(dtype=float)])[0]
        y = (solver.p_cell / solver.elastic.multipliers.uniform - mean / grid.cell_points) * grid.a
        y += heights.top * share - heights.lowest * (1 - share)
        return y, _error(y, progress.gap_mean * grid.a, *errors)

    def within(self, solver: Solver, progress: Progress, room: float) -> bool:
        """Compare the error of what is predicted."""
        found = self._prediction(solver, progress)
        return not found or found[1] < room

    def certified(self, solver: Solver, certificate: Certificate) -> Value:
        """Give the approach of the certificate."""
        y, a = certificate.approach * solver.grid.a, solver.grid.a
        return y, _error(y, certificate.gap_mean * a, *certificate.errors[1:])


def _error(y: float, gap: float, gap_error: float, pressure_error: float) -> float:
    """Estimate the error of an approach y at a mean gap."""
    return gap_error * gap / y + CALIBRATION.field * pressure_error if y > 0 else inf


SEARCHES: dict[str, type[SecantSearch]] = {
    "a_r": AreaSearch,
    "gap_mean": GapSearch,
    "approach": ApproachSearch,
}


def search_for(
    load: Load,
    surface: Surface,
    known: Known,
    history: Sequence[dict[str, float]],
    hardness: float | None = None,
) -> SecantSearch:
    """Begin the search for the load that gives a target.

    known: the tolerance, whether the error of the solution counts towards it, and the heights;
    history: loads that were solved before, p0 and what each gave.
    """
    tolerance, counts, heights = known
    value = load.value if load.quantity == "a_r" else load.value / surface.slope
    kind = SEARCHES[load.quantity]
    search = kind(
        value, tolerance, counts, heights, heights, closes_at=hardness or inf, slope=kind.usual
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
