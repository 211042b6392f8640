"""The searches for a load that gives a mean gap, or an approach."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, log
from typing import TYPE_CHECKING

from .search import Search

if TYPE_CHECKING:
    from ..certificate.certificate import Certificate
    from ..solvers.base import Outlook, Progress, Solver
    from ..surface import Surface
    from .prescribed import Prescribed

# of the error of the pressure field, beside that of the mean gap: the error of the approach
FIELD = 0.1


@dataclass
class GapSearch(Search):
    """For a mean gap."""

    quantity = kind = "gap_mean"
    usual, bent, trend = 0.6, 1.0, 0.3
    noise, change = 0.12, 0.15

    def guess(self, load: Prescribed, surface: Surface) -> float:
        """A first guess of log p0: that of self-affine walls."""
        return -1 - 3 * load.value / surface.h_rms

    def straight(self, y: float) -> float:
        """The mean gap decreases like exp(-c p0^s)."""
        return log(log(self.wall.top / y)) if 0 < y < self.wall.top else (-inf if y > 0 else inf)

    def _expected(self, solver: Solver, outlook: Outlook) -> float:
        return outlook.gap_mean * solver.grid.a

    def _present(self, solver: Solver, progress: Progress, expected: float) -> float:
        return progress.gap_mean * solver.grid.a

    def _of(self, solver: Solver, certificate: Certificate) -> float:
        return certificate.gap_mean * solver.grid.a

    def _error(
        self, y: float, gap: float, area_error: float, gap_error: float, pressure_error: float
    ) -> float:
        return gap_error


@dataclass
class ApproachSearch(Search):
    """For an approach."""

    quantity = kind = "approach"
    usual, bent, trend = 0.8, 1.0, 0.3
    noise, change = 0.2, 0.1

    def guess(self, load: Prescribed, surface: Surface) -> float:
        """A first guess of log p0."""
        return log(self.target / max(surface.sizes))

    def straight(self, y: float) -> float:
        """A power law."""
        return log(y) if y > 0 else -inf

    def _expected(self, solver: Solver, outlook: Outlook) -> float:
        grid = solver.grid
        rise, share = (
            grid.comm.sum([solver.g.sum(dtype=float)])[0] / grid.cell_points + outlook.rise,
            grid.N / grid.cell_points,
        )
        y = (solver.p_cell / solver.elastic.multipliers.uniform - rise) * grid.a
        return float(y + self.wall.top * share - self.wall.lowest * (1 - share))

    def _of(self, solver: Solver, certificate: Certificate) -> float:
        return certificate.approach * solver.grid.a

    def _error(
        self, y: float, gap: float, area_error: float, gap_error: float, pressure_error: float
    ) -> float:
        return gap_error * gap / y + FIELD * pressure_error if y > 0 else inf
