"""Errors of the solution from the error of its energy, without knowing the solution: equations (8)
and (9) in docs/method.md.

With e = u - u* the distance from the solution, E(u) - E* = <p*, g> + 1/2 <e, K e> <= G, the duality
gap of any admissible pressure. So <e, K e> <= 2 G, which bounds the pressure: |p - p*|^2 = |K e|^2
<= K_max <e, K e>. The mean gap is wrong by mean(e). For a test pressure v of zero mean, <v, e> is
at most |v|_S |e|_K; two of them give mean(e):

- v = p* - p0: <p*, e> = <p*, g> is between 0 and G - 1/2 <e, K e>, so |mean(e)| <= |u*|_K sqrt(2
  G)/(N p0), a bound;
- v = -1 out of contact and constant in contact, where e vanishes but at points that change sides:
  |mean(e)| = |<v, S (p - p*)>|/N, which is far smaller where little is out of contact. Here p* is
  p^ but for a part that is at most half of the bound |v|_S sqrt(2 G)/N, because 1/2 <e, K e> is
  nearly all of G; and <v, S (p - p^)> is known.

With a hardness H, G+ and Y being the sums of the gaps and of the depths of dents less those of the
solution, 0 <= <p*, e> + H Y <= G and sum(e) = G+ - Y. So the first v bounds p0 G+ + (H - p0) Y, the
second one G+ - Y, and the error of the mean gap is their mean, with weights p0/H and 1 - p0/H.

With free edges the first v bounds the mean of e over the cell. The mean over the surface alone
differs by <v, e>/N, where v = 1 on the surface (less its mean); its |v|_S, the self-energy of the
nominal area, is known beforehand. The second v is -1 on the open points of the surface, constant in
contact and 0 beyond: t N/n - s on every level, where t and s are the indicators of the n points in
contact and of the surface.

An error dS of S itself (Body.error) acts like smooth errors dS p of the heights. The pressure is
wrong by about -K dS p in full contact, by less otherwise. The mean gap changes with it as with the
load, by |v|_S^2 with the second v; the gap of the open points alone changes by less, unless they
are at the edges of the surface, where most of this error is. If only the last m points are open, as
in corners, all of the error may be there: it opens them by sqrt(m) times its norm, times the
compliance of m points.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot, inf, isfinite, sqrt
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..operators.multilevel import EQUIVALENCE
from ..operators.problem import ROUNDING, self_energy
from .plastic_limits import further_movement

if TYPE_CHECKING:
    from ..operators.multilevel import Multilevel
    from ..operators.problem import Problem


@dataclass(frozen=True)
class EstimateCalibration:
    """Calibrated factors of the error estimates, for what sums over points do not bound.

    Calibrated on true errors of walls of all kinds (scripts/campaign): at most one true error in a
    thousand loads exceeds its estimate.

    Attributes
    ----------
    pressure : float
        Error of the pressure field, over the formula of its bound with the stiffness of a typical
        wave instead of the stiffest; the largest seen was 0.64.
    unknown : float
        Factor on the bound of the mean gap's error, for the unknown part of p* (in theory at most
        0.5).
    shift : float
        S of long waves over the sum over levels that stands for it.
    loaded, corner : float
        Effect of an error of S on the mean gap. `loaded`: over the effect of an equal relative
        error of the load, all points counted as open. `corner`: over the norm of that error, while
        only the last points are open. The largest seen were 0.04 and 0.22.
    reach : float
        Points may change sides if this takes a change of pressure below `reach` times its rms error
        (taken over the points that have it): 0.5 for random roughness, 1.3 for lattices of equal
        points. Only one half of this range counts, the one with more points: in random roughness
        both have equally many. Counts of n points scatter by sqrt(n), which is added.
    farthest, few : float
        Up to `few` points may change sides if this takes less than `farthest` times that rms error.
    rounding : float
        Changes of pressure below this factor times its rms rounding error cannot tell on which side
        a point is.
    """

    pressure: float = 0.7
    unknown: float = 0.5
    shift: float = 1.2
    loaded: float = 0.05
    corner: float = 0.3
    reach: float = 1.75
    farthest: float = 12.0
    few: float = 3.0
    rounding: float = 4.0


CALIBRATION = EstimateCalibration()


class State(NamedTuple):
    """Sums over the points of a state, over all ranks, in the problem's units.

    Attributes
    ----------
    p0 : float
        Mean pressure that the wall bears.
    open_p, open_pp : float
        Sums of p and p^2 over open points; points that yield add p less the hardness.
    closed_pp : float
        Sum of p^2 over points in contact.
    contact : float
        Number of points in contact, yielded ones included.
    yielded : float
        Number of points that yield.
    gap : float
        Sum of the gaps; dents count as 0.
    uKu : float
        <u, K u>.
    level_sums : sequence of float
        The last five sums that Multilevel.sweep returns, over all ranks.
    """

    p0: float
    open_p: float
    open_pp: float
    closed_pp: float
    contact: float
    yielded: float
    gap: float
    uKu: float
    level_sums: Sequence[float]

    @property
    def elastic(self) -> float:
        """Number of points in elastic contact, which can carry a missing load; 1 if all of the
        contact yields."""
        if self.contact == self.yielded > 0:
            return 1.0
        return self.contact - self.yielded


class Estimate(NamedTuple):
    """Estimated errors of a state. All defaults together mean that nothing is known.

    Attributes
    ----------
    gap, pressure : float
        Relative errors of the mean gap and of the pressure field (L2 norm).
    attainable : tuple of float
        Their parts (gap, pressure) that further iterations cannot reduce, the rounding errors, if
        these are larger than the rest; else 0.
    squares : float
        Sum over points of the squared error of the pressure.
    shift : float
        Signed estimate of how much the sum of gaps will still change.
    missing_load : float
        Share of the load that the contact does not carry; below 0 if it carries too much.
    fall : float
        Height by which the body may move further than the linear estimate says, because all of the
        elastic contact yields or opens (plastic_limits.py).
    distance : float
        Estimate of |u - T(u)|_K, where T(u) is the contact with the attraction of u frozen.
    """

    gap: float = np.inf
    pressure: float = np.inf
    attainable: tuple[float, float] = (0.0, 0.0)
    squares: float = np.inf
    shift: float = np.nan
    missing_load: float = 0.0
    fall: float = 0.0
    distance: float = np.inf


class Norms(NamedTuple):
    """S norms and product of the residual pressure p^ - p and the test pressure v.

    Attributes
    ----------
    missing : float
        |p^ - p|_S; with an attraction divided by the stability.
    response : float
        |v|_S, where v is -1 on open points and a constant in contact that gives it zero mean.
    shift : float
        <v, S (p - p^)>; with an attraction divided by the stability.
    """

    missing: float
    response: float
    shift: float


def estimate(
    problem: Problem, levels: Multilevel, g: np.ndarray, state: State, stability: float = 1.0
) -> Estimate:
    """Estimate the errors of a state from its sums, without an FFT. Collective.

    Solvers and certificates use it alike; nothing is changed. p^ is the pressure in contact plus a
    constant that makes up for the pressure out of contact. Rounding errors of the working precision
    are those of the heights, which are independent from point to point, and those of the pressure,
    which count as an error of the load.

    With an attraction the estimate is first that of the contact under the same attraction, frozen.
    The equilibrium is farther away by a factor of 1/stability (stability.py).

    Parameters
    ----------
    problem : Problem
        The contact. `state.p0` is used instead of its load.
    levels : Multilevel
        Multilevel operator of the grid; only its norms are used, not its fields.
    g : array, local slab
        Gap of the state.
    state : State
        Sums over all ranks.
    stability : float
        Stability of the equilibrium, 1 without an attraction.

    Returns
    -------
    Estimate
        The same on all ranks. Infinite errors if a sum is not finite, nothing is in contact, or the
        stability or the load of the wall is not positive.
    """
    N = problem.grid.N
    is_finite = isfinite(state.open_pp + state.gap + state.uKu)
    carries = state.p0 > 0 and state.elastic > 0 and state.closed_pp > 0
    if not (is_finite and stability > 0 and carries):
        return Estimate()
    norms = _norms(problem, levels, state, stability)
    distance = norms.missing * stability
    # where points yield the formula of the bound itself counts
    share = CALIBRATION.pressure if problem.hardness is None else 1.0
    # on a soft base short waves may be stiffer than the typical one says
    body, grid = problem.body, problem.grid
    squares = (share * norms.missing) ** 2 * max(body.typical(grid), body.scale(grid))
    relative = sqrt(squares / state.closed_pp)
    rounding = _rounding_of_pressure(problem, state) / stability
    pressure = hypot(relative, rounding)
    attainable_pressure = rounding if relative < rounding else 0.0
    if state.contact == N:
        return Estimate(0.0, pressure, (0.0, attainable_pressure), squares, 0.0, distance=distance)

    further = further_movement(
        problem, N * state.p0, g, state.gap, state.contact, norms.missing, norms.response
    )
    wrong = _error_of_gaps(problem, state, norms) + further
    rounding_of_gaps = _rounding_of_gaps(problem, state, norms) / stability
    attainable_gap = 0.0
    if wrong < rounding_of_gaps:
        attainable_gap = relative_error(rounding_of_gaps, state.gap)
    n_open = N - state.contact
    return Estimate(
        gap=relative_error(wrong + rounding_of_gaps, state.gap),
        pressure=pressure,
        attainable=(attainable_gap, attainable_pressure),
        squares=squares,
        shift=n_open / max(N - state.elastic, 1) * norms.shift,  # free points that do not yield
        missing_load=state.open_p / (N * state.p0),
        fall=further / n_open,
        distance=distance,
    )


def _norms(problem: Problem, levels: Multilevel, state: State, stability: float) -> Norms:
    """Return the Norms of a state, by sums over levels; `stability` divides two of them. Local."""
    compliance = 1.0 / problem.body.scale(problem.grid)
    share = state.elastic / problem.grid.N
    residual, test, product = levels.test_products(
        state.open_p, state.open_pp, state.elastic, *state.level_sums
    )
    return Norms(
        missing=sqrt(EQUIVALENCE * compliance * residual) / stability,
        response=sqrt(compliance * test) / share,
        shift=compliance * product / share / stability,
    )


def _error_of_gaps(problem: Problem, state: State, norms: Norms) -> float:
    """Estimate the absolute error of the sum of gaps, without rounding errors. Local.

    It holds while points in elastic contact stay so; `further_movement` adds the rest. It is the
    smaller of the estimates by the two test pressures at the head of the file. With yielded points
    the first of them is a weighted mean of both.
    """
    by_load = inf  # where an attraction differs from point to point this test says nothing
    if problem.attraction is None:
        norm = sqrt(max(state.uKu, 0.0))
        edges = self_energy(problem.grid)
        by_load = norms.missing * ((norm + norms.missing) / state.p0 + edges)
    share = CALIBRATION.unknown if problem.hardness is None else 1.0
    by_contact = share * norms.response * norms.missing + CALIBRATION.shift * abs(norms.shift)
    if state.yielded:
        by_load += (by_contact - by_load) * (1 - state.p0 / (problem.hardness or inf))
    return min(by_load, by_contact)


def _rounding_of_pressure(problem: Problem, state: State) -> float:
    """Return the relative error of the pressure field due to rounding errors and an error of S.

    Iterations cannot reduce it. Collective when the rounding error of the problem is first read.
    """
    # with a hardness most of the contact may yield
    points = state.elastic if problem.hardness is None else state.contact
    of_heights = problem.rounding / sqrt(state.closed_pp / points)
    return hypot(of_heights, _epsilon(problem), problem.body.error)


def _rounding_of_gaps(problem: Problem, state: State, norms: Norms) -> float:
    """Return the absolute error of the sum of gaps due to rounding errors and an error of S."""
    N = problem.grid.N
    free = N - state.elastic
    width = sqrt(free)
    # the last m points open by sqrt(m)/2
    last_points = CALIBRATION.corner * sqrt(N) * width * max(1, width / 2)
    compliance = 1.0 / problem.body.scale(problem.grid)
    as_load = CALIBRATION.loaded * (norms.response**2 + compliance * N)
    of_body = problem.body.error * state.p0 * min(as_load, last_points)
    of_sums = _epsilon(problem) * (state.p0 * norms.response**2 + state.gap)
    return of_body + (of_sums + problem.rounding * free)


def _epsilon(problem: Problem) -> float:
    """Return the relative rounding error of the working precision."""
    return ROUNDING * float(np.finfo(problem.dtype).eps)


def relative_error(wrong: float, value: float) -> float:
    """Return the error of a number relative to the true one.

    Parameters
    ----------
    wrong : float
        Largest distance of the number from the true one, >= 0.
    value : float
        The number, >= 0.

    Returns
    -------
    float
        wrong/(value - wrong), the largest that is possible; 0 if `wrong` is 0, infinite if the true
        number may be 0.
    """
    if wrong < value:
        return float(wrong / (value - wrong))
    return 0.0 if wrong == 0 else np.inf
