"""Mean gap and approach: quantities whose load the root-finder (root.py) finds.

Each is its value, predicted by the solver or certified, and a function that makes it nearly linear
in x = log p0; areas, which go in steps, are in prescribed_area.py. See "Prescribed areas, gaps and
approaches" in docs/method.md.
"""

from __future__ import annotations

from math import inf, log
from typing import TYPE_CHECKING

from .prescribed_area import Area
from .root import Root, Value

if TYPE_CHECKING:
    from ..certificate.certificate import Certificate
    from ..solvers.base import Progress, Solver
    from ..surface import Surface
    from .working_surface import WorkingSurface

# `opening_load` below which a gap is sought from full contact. Chosen: alike from 5 to 20; at .2
# gaps of 1e-5 h_rms take 3 times the pairs, at 1000 those of 1e-2 h_rms 1.7 times
NEARLY_CLOSED = 5.0
# Share of the error of the pressure field that counts as error of an approach. Chosen: from .025 to
# .4 no approach of 27 open walls and layers is wrong, and loads take 22.8 to 19.6 pairs.
FIELD = 0.1


class Gap(Root):
    """A mean gap, in lengths over the unit of slopes."""

    quantity = "gap_mean"
    usual = 0.4

    def guess(self, surface: Surface) -> float:
        """By the gap of self-affine walls, or of a single point that carries the load."""
        alone = (self.heights.top - self.value) / (surface.grid.a * self.heights.points)
        return max(-1 - 2 * self.value * surface.slope / surface.h_rms, log(alone))

    def straight(self, y: float) -> float:
        """log(log(top/y)), as the mean gap decreases like top exp(-c p0^s)."""
        if y <= 0:
            return inf
        return log(log(self.heights.top / y)) if y < self.heights.top else -inf

    def predicted(self, solver: Solver, progress: Progress) -> Value | None:
        assert progress.estimate is not None
        error = progress.estimate.gap
        if progress.contact == solver.N:
            error = max(error, progress.estimate.pressure)
        return (progress.predicted[1] * solver.grid.a, error) if progress.predicted else None

    def within(self, solver: Solver, progress: Progress, room: float) -> bool:
        estimate = progress.estimate
        if estimate is None:
            return True
        return estimate.gap < room or estimate.attainable[0] >= self.tolerance

    def certified(self, solver: Solver, certificate: Certificate) -> Value:
        """An error that rounding keeps above the tolerance does not count: nothing can help."""
        is_limited = certificate.attainable[0] >= self.tolerance
        error = 0.0 if is_limited else certificate.errors[1]
        return certificate.gap_mean * solver.grid.a, error


class Opening(Gap):
    """A mean gap next to full contact, a power of (closes_at - p0)/p0, from a gap of 0: half the
    pairs of `Gap` where few points are open. closes_at: the load that closes the gap; opens: how
    far below that one open point makes the gap.
    """

    usual = 1.5
    from_full_contact = True

    def __init__(self, value: float, working: WorkingSurface, opens: float, closes_at: float):
        super().__init__(value, working)
        self.closes_at = closes_at
        self._go(log(closes_at) + log(max(closes_at / opens - 1, 1.0)))

    def straight(self, y: float) -> float:
        """log(top/y), linear in log(p0/(closes_at - p0))."""
        return log(self.heights.top / y) if y > 0 else inf


class Approach(Root):
    """An approach of the bodies, in lengths over the unit of slopes."""

    quantity = "approach"
    usual = 0.8

    def guess(self, surface: Surface) -> float:
        """By the approach of a flat punch as large as the surface."""
        return log(self.value / max(surface.sizes))

    def straight(self, y: float) -> float:
        """log(y), as the approach is a power of the load."""
        return log(y) if y > 0 else -inf

    def predicted(self, solver: Solver, progress: Progress) -> Value | None:
        """Of the present displacement, not of the converged one."""
        grid = solver.grid
        share = grid.N / grid.cell_points
        (total_gap,) = grid.comm.sum([solver.state.g.sum(dtype=float)])
        uniform = solver.state.p_cell / solver.elastic.multipliers.uniform
        y = (uniform - total_gap / grid.cell_points) * grid.a
        y += self.heights.top * share - self.heights.lowest * (1 - share)
        assert progress.estimate is not None
        return y, self._error(y, progress.gap_mean * grid.a, *progress.estimate[:2])

    def certified(self, solver: Solver, certificate: Certificate) -> Value:
        a = solver.grid.a
        y = certificate.approach * a
        return y, self._error(y, certificate.gap_mean * a, *certificate.errors[1:])

    def _error(self, y: float, gap: float, gap_error: float, pressure_error: float) -> float:
        """Return the relative error of y by those of the mean gap and of the pressure field."""
        return gap_error * gap / y + FIELD * pressure_error if y > 0 else inf


def opening_load(gap_mean: float, working: WorkingSurface) -> float:
    """Return how far below full contact (program's unit) one open point alone makes a mean gap."""
    grid = working.surface.grid
    gap_of_point = gap_mean / working.surface.height_unit * grid.N
    return gap_of_point * float(working.model.body.near(grid)[0])


ROOTS: dict[str, type[Root]] = {root.quantity: root for root in (Area, Gap, Approach)}
