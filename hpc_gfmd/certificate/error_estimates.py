"""Errors of the solution from the error of its energy: equations (8) and (9) in docs/method.md.

With e = u - u* and the duality gap G, <e, K e> <= 2 G bounds the pressure, |p - p*|^2 <= K_max <e,
K e>. The mean gap is wrong by mean(e), for which there are two test pressures v, |<v, e>| <= |v|_S
|e|_K:

- v = p* - p0: |mean(e)| <= |u*|_K sqrt(2 G)/(N p0), a bound;
- v = -1 out of contact and constant in contact, where e vanishes but at points that change sides:
  |mean(e)| = |<v, S (p - p*)>|/N, far smaller where little is out of contact. Here p* is p^ but for
  a part that is at most half of |v|_S sqrt(2 G)/N, because 1/2 <e, K e> is nearly all of G; and <v,
  S (p - p^)> is known.

With a hardness H, G+ and Y being the errors of the sums of gaps and of depths of dents, 0 <= <p*,
e> + H Y <= G and sum(e) = G+ - Y. So the first v bounds p0 G+ + (H - p0) Y, the second one G+ - Y,
and the error of the mean gap is their mean, with weights p0/H and 1 - p0/H.

With free edges the first v bounds the mean of e over the cell; that over the surface differs by <v,
e>/N, where v = 1 on the surface (less its mean), whose |v|_S is the self-energy of the nominal
area. The second v is 0 beyond the surface: t N/n - s on every level, t and s being the indicators
of the n points in contact and of the surface.

An error dS of S itself (Body.error) acts like smooth errors dS p of the heights. The pressure is
wrong by about -K dS p in full contact, by less otherwise. The mean gap changes as with the load, by
|v|_S^2 with the second v; that of the open points alone changes by less, unless they are at the
edges of the surface, where most of this error is. If only the last m points are open, as in
corners, all of the error may be there: it opens them by sqrt(m) times its norm, times the
compliance of m points.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import copysign, hypot, inf, isfinite, sqrt
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..operators.multilevel import EQUIVALENCE
from ..operators.problem import ROUNDING, self_energy
from .plastic_limits import further_movement

if TYPE_CHECKING:
    from ..operators.multilevel import Multilevel
    from ..operators.problem import Problem

# Factors for what sums over points do not bound. Calibrated on true errors of walls of all kinds
# (scripts/campaign): at most one true error in a thousand loads exceeds its estimate.
#
# Error of the pressure field, over the formula of its bound with the stiffness of a typical wave
# instead of the stiffest; the largest seen was 0.64.
OF_PRESSURE = 0.7
# Factor on the bound of the mean gap's error, for the unknown part of p* (in theory <= 0.5).
UNKNOWN = 0.5
LONG_WAVES = 1.2  # S of long waves over the sum over levels that stands for it
# Effect of an error of S on the mean gap, over that of an equal relative error of the load, all
# points counted as open; the largest seen was 0.04.
AS_LOAD = 0.05
# Effect of an error of S on the mean gap, over the norm of that error, while only the last points
# are open; the largest seen was 0.22.
LAST_POINTS = 0.3


class StateSums(NamedTuple):
    """Sums over the points of a state, over all ranks, in the problem's units."""

    p0: float  # mean pressure that the wall bears
    open_p: float  # sum over open points; points that yield add p less the hardness
    open_pp: float  # the same of p^2
    closed_pp: float  # sum of p^2 over points in contact
    contact: float  # number of points in contact, yielded ones included
    yielded: float  # number of points that yield
    gap: float  # sum of the gaps; dents count as 0
    uKu: float  # <u, K u>
    level_sums: Sequence[float]  # the last five sums that Multilevel.sweep returns

    @property
    def elastic(self) -> float:
        """Number of points in elastic contact, which can carry a missing load; 1 if all yield."""
        if self.contact == self.yielded > 0:
            return 1.0
        return self.contact - self.yielded


class Estimate(NamedTuple):
    """Estimated errors of a state. All defaults together mean that nothing is known."""

    gap: float = np.inf  # relative error of the mean gap
    pressure: float = np.inf  # relative error of the pressure field (L2 norm)
    # Parts of `gap` and `pressure` that further iterations cannot reduce, rounding errors and those
    # of the heights, if these are larger than the rest; else 0.
    attainable: tuple[float, float] = (0.0, 0.0)
    squares: float = np.inf  # sum over points of the squared error of the pressure
    shift: float = np.nan  # signed estimate of how much the sum of gaps will still change
    # points by which the contact grows until it carries the load; < 0 if it shrinks
    growth: float = 0.0
    # Height by which the body may move further than the linear estimate says, because all of the
    # elastic contact yields or opens (plastic_limits.py).
    fall: float = 0.0
    distance: float = np.inf  # |u - T(u)|_K, T(u) being the contact with the attraction of u frozen

    def reduced(self, factor: float) -> Estimate:
        """Return the estimate of a state whose errors are so many times smaller."""
        return self._replace(
            gap=self.gap / factor,
            pressure=self.pressure / factor,
            squares=self.squares / factor**2,
            shift=self.shift / factor,
            growth=self.growth / factor,
            distance=self.distance / factor,
        )


class Norms(NamedTuple):
    """S norms and product of p^ - p and the test pressure v at the head of the file."""

    # |p^ - p|_S, with an attraction divided by the stability, and the error of the heights
    missing: float
    response: float  # |v|_S
    shift: float  # <v, S (p - p^)>; with an attraction divided by the stability
    inherited: float  # share of `missing` that is the error of the heights


def estimate(
    problem: Problem, levels: Multilevel, g: np.ndarray, sums: StateSums, stability: float = 1.0
) -> Estimate:
    """Estimate the errors of a state from its sums and the norms of `levels`, without an FFT.
    Collective.

    p^ is the pressure in contact plus a constant for that out of contact. Rounding: of the heights,
    independent from point to point, and of the pressure, an error of the load. With an attraction:
    of the contact under the same, frozen, attraction, over the stability. Infinite if a sum is not
    finite, nothing touches, or stability or load of the wall is not positive.
    """
    N = problem.grid.N
    is_finite = isfinite(sums.open_pp + sums.gap + sums.uKu)
    carries = sums.p0 > 0 and sums.elastic > 0 and sums.closed_pp > 0
    if not (is_finite and stability > 0 and carries):
        return Estimate()
    norms = _norms(problem, levels, sums, stability)
    distance = norms.missing * stability
    squares = norms.missing**2 * _squares_of_norm(problem)
    relative = sqrt(squares / sums.closed_pp)
    rounding = _rounding_of_pressure(problem, sums) / stability
    pressure = hypot(relative, rounding)
    stays = hypot(relative * norms.inherited, rounding)
    attainable_pressure = stays if relative * sqrt(1 - norms.inherited**2) < stays else 0.0
    if sums.contact == N:
        return Estimate(0.0, pressure, (0.0, attainable_pressure), squares, 0.0, distance=distance)

    further = further_movement(
        problem, N * sums.p0, g, sums.gap, sums.contact, norms.missing, norms.response
    )
    wrong = _error_of_gaps(problem, sums, norms) + further
    rounding_of_gaps = _rounding_of_gaps(problem, sums, norms) / stability
    stays = wrong * norms.inherited + rounding_of_gaps
    attainable_gap = 0.0
    if wrong * (1 - norms.inherited) < stays:
        attainable_gap = relative_error(stays, sums.gap)
    n_open = N - sums.contact
    return Estimate(
        gap=relative_error(wrong + rounding_of_gaps, sums.gap),
        pressure=pressure,
        attainable=(attainable_gap, attainable_pressure),
        squares=squares,
        shift=n_open / max(N - sums.elastic, 1) * norms.shift,  # free points that do not yield
        growth=_growth(problem, sums),
        fall=further / n_open,
        distance=distance,
    )


def _norms(problem: Problem, levels: Multilevel, sums: StateSums, stability: float) -> Norms:
    """Return the Norms of a state, by sums over levels; `stability` divides two of them. Local."""
    compliance = 1.0 / problem.body.scale(problem.grid)
    share = sums.elastic / problem.grid.N
    residual, test, product = levels.test_products(
        sums.open_p, sums.open_pp, sums.elastic, *sums.level_sums
    )
    missing = sqrt(EQUIVALENCE * compliance * residual) / stability
    of_heights = problem.height_error / sqrt(_squares_of_norm(problem))
    together = hypot(missing, of_heights)
    return Norms(
        missing=together,
        response=sqrt(compliance * test) / share,
        shift=compliance * product / share / stability,
        inherited=of_heights / together if of_heights else 0.0,
    )


def _squares_of_norm(problem: Problem) -> float:
    """Return the sum of squares of a pressure over its squared S norm, as it is estimated."""
    # where points yield the formula of the bound itself counts
    share = 1.0 if problem.yields else OF_PRESSURE
    # on a soft base short waves may be stiffer than the typical one says
    body, grid = problem.body, problem.grid
    return share**2 * max(body.typical(grid), body.scale(grid))


def _growth(problem: Problem, sums: StateSums) -> float:
    """Return by how many points the contact grows until it carries the load.

    The elastic contact grows in proportion to what it carries; points that yield carry no more. If
    they carry all of the load, nothing is known.
    """
    carried = problem.grid.N * sums.p0 - sums.open_p
    if sums.yielded:
        carried -= problem.hardness * sums.yielded
    if carried > 0:
        return sums.open_p * (sums.contact - sums.yielded) / carried
    return copysign(inf, sums.open_p)


def _error_of_gaps(problem: Problem, sums: StateSums, norms: Norms) -> float:
    """Return the absolute error of the sum of gaps, the smaller of both test pressures, without
    rounding, while elastic points stay so.
    """
    by_load = inf  # where an attraction differs from point to point this test says nothing
    if problem.attraction is None:
        norm = sqrt(max(sums.uKu, 0.0))
        edges = self_energy(problem.grid)
        by_load = norms.missing * ((norm + norms.missing) / sums.p0 + edges)
    share = 1.0 if problem.yields else UNKNOWN
    # of the error of the heights all is unknown
    share = hypot(share * sqrt(1 - norms.inherited**2), norms.inherited)
    by_contact = share * norms.response * norms.missing + LONG_WAVES * abs(norms.shift)
    if sums.yielded:
        by_load += (by_contact - by_load) * (1 - sums.p0 / problem.hardness)
    return min(by_load, by_contact)


def _rounding_of_pressure(problem: Problem, sums: StateSums) -> float:
    """Return the relative pressure error by rounding and an error of S. Collective at first."""
    # with a hardness most of the contact may yield
    points = sums.contact if problem.yields else sums.elastic
    of_heights = problem.rounding / sqrt(sums.closed_pp / points)
    return hypot(of_heights, _epsilon(problem), problem.body.error)


def _rounding_of_gaps(problem: Problem, sums: StateSums, norms: Norms) -> float:
    """Return the absolute error of the sum of gaps due to rounding errors and an error of S."""
    N = problem.grid.N
    free = N - sums.elastic
    width = sqrt(free)
    # the last m points open by sqrt(m)/2
    last_points = LAST_POINTS * sqrt(N) * width * max(1, width / 2)
    compliance = 1.0 / problem.body.scale(problem.grid)
    as_load = AS_LOAD * (norms.response**2 + compliance * N)
    of_body = problem.body.error * sums.p0 * min(as_load, last_points)
    of_sums = _epsilon(problem) * (sums.p0 * norms.response**2 + sums.gap)
    return of_body + (of_sums + problem.rounding * free)


def _epsilon(problem: Problem) -> float:
    return ROUNDING * float(np.finfo(problem.dtype).eps)


def relative_error(wrong: float, value: float) -> float:
    """Return the largest error over the true number, wrong/(value - wrong); inf if it may be 0."""
    if wrong < value:
        return float(wrong / (value - wrong))
    return 0.0 if wrong == 0 else np.inf
