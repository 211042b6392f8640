"""Errors of the solution from the error of its energy, without knowing the solution.

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

Where the surface ends within the cell the first is a bound of the mean of e over the cell. That
over the surface alone is different by <v, e>/N, v = 1 on the surface (less its mean): |v|_S is
known beforehand, it is the self-energy of the nominal area. The second v is -1 on the surface out
of contact, constant in contact and 0 beyond: on every level t N/n - s, t and s being the indicators
of the n points in contact and of the surface.

An error dS of S itself (Body.error) acts as heights wrong by dS p, smooth ones: the pressure is
wrong by about -K dS p where all is closed, elsewhere by less. The mean gap follows it as it follows
the load, by |v|_S^2 with the second v: of the open points alone by less than that, unless they are
at the edges of the surface, where most of that error is. All of it may be where the last m points
are open, as in corners: it opens them by the root of m times its norm, times the compliance of m
points.
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
    """How large the errors are that sums alone do not bound.

    Calibrated on true errors of walls of all kinds (scripts/campaign), with a margin such that a
    true error is above its estimate once in a thousand loads or less.

    Attributes
    ----------
    pressure : float
        The error of the pressure field over the bound with the compliance of a typical wave in
        place of the stiffest: 0.64 was seen.
    unknown : float
        In the error of the mean gap, the part of the bound that stands for what is not known of
        the solution: at most a half.
    shift : float
        S of long waves over its sum over levels.
    loaded, corner : float
        What an error of S does to the mean gap, over what as large an error of the load does, with
        all points counted as open; of its norm, where the last points are open (0.04 and 0.22 were
        seen).
    reach : float
        Points change sides if that takes less than so many times the rms error of the pressure,
        where that error is: 0.5 for random roughness, 1.3 for lattices of alike points. One half of
        this range counts, the one with more points: random roughness has as many in both. Counts
        of n points scatter by the root of n, which is added.
    farthest, few : float
        So many points change sides if that takes less than `farthest` times that rms.
    rounding : float
        Times the rms rounding errors of the pressure: less tells no side.
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
    """Sums over all points of a state, on all ranks.

    Attributes
    ----------
    p0 : float
        Mean pressure that the wall bears.
    open_p, open_pp : float
        Sums of p and p^2 out of contact; where a point yields, of the pressure beyond the hardness.
    closed_pp : float
        Sum of p^2 in contact.
    contact : float
        Number of points in contact, yielded ones included.
    yielded : float
        Number of points that yield.
    gap : float
        Sum of the gaps.
    uKu : float
        <u, K u>.
    level_sums : sequence of float
        What Multilevel.sweep returns of the pressure out of contact.
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
        """Number of points that carry what is missing: those in elastic contact, at least the one
        that balances the load where all others yield."""
        if self.contact == self.yielded > 0:
            return 1.0
        return self.contact - self.yielded


class Estimate(NamedTuple):
    """Errors that are expected of a state.

    Attributes
    ----------
    gap, pressure : float
        Relative, of the mean gap and of the pressure field.
    attainable : tuple of float
        The part of both that no iteration makes smaller, where that is most of it, else 0.
    squares : float
        Squares of the error of the pressure, summed over points.
    shift : float
        Error of the sum of gaps by the load that is missing or misplaced.
    missing_load : float
        Share of the load that is missing in contact; below 0 where the contact carries too much.
    fall : float
        Height by which the body may move further than its elastic contact says, because all that
        is elastic yields or opens (plastic_limits.py).
    distance : float
        Bound of |u - T(u)|_K, T(u) being the contact with the attraction frozen.
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
    """Norms of what is left of the pressure, in the problem's units.

    Attributes
    ----------
    missing : float
        |p^ - p|_S.
    response : float
        |v|_S of the test pressure v that is -1 on open points and makes up for it in contact.
    shift : float
        <v, S (p - p^)>.
    """

    missing: float
    response: float
    shift: float


def estimate(
    problem: Problem, levels: Multilevel, g: np.ndarray, state: State, stability: float = 1.0
) -> Estimate:
    """Return the errors of a state, for solver and certificate alike. Collective.

    p^ is the pressure in contact, more by as much at each point as makes up for what is left out of
    contact. Rounding errors of the working precision are those of the heights, which are
    independent from point to point, and those of the pressure, as a load that is wrong by as much.

    With an attraction all this is about the contact under the same attraction, frozen. The
    equilibrium is 1/stability as far away (stability.py).

    Parameters
    ----------
    problem : Problem
        The contact; its load does not count.
    levels : Multilevel
        Of the grid.
    g : array, local slab
        Gap of the state.
    state : State
        Sums over all ranks.
    stability : float
        Of the equilibrium.

    Returns
    -------
    Estimate
        All infinite where nothing is known.
    """
    N = problem.grid.N
    is_finite = isfinite(state.open_pp + state.gap + state.uKu)
    carries = state.p0 > 0 and state.elastic > 0 and state.closed_pp > 0
    if not (is_finite and stability > 0 and carries):
        return Estimate()
    norms = _norms(problem, levels, state, stability)
    distance = norms.missing * stability
    # where points yield the bound itself counts
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
    """Return the norms of what is left of the pressure, by sums over levels."""
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
    """Estimate the absolute error of the sum of gaps, as long as points in elastic contact stay
    so (`further_movement` has the rest). Local.

    It is the smaller one of the two tests at the head of the file, by the load and by the
    contact, or their weighted mean where points yield."""
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
    """Return the relative error of the pressure field that no iteration makes smaller."""
    # with a hardness most of the contact may yield
    points = state.elastic if problem.hardness is None else state.contact
    of_heights = problem.rounding / sqrt(state.closed_pp / points)
    return hypot(of_heights, _epsilon(problem), problem.body.error)


def _rounding_of_gaps(problem: Problem, state: State, norms: Norms) -> float:
    """Return the error of the sum of gaps that no iteration makes smaller."""
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
        How far it may be from the true one.
    value : float
        The number.

    Returns
    -------
    float
        Infinite where the true one may be 0.
    """
    if wrong < value:
        return float(wrong / (value - wrong))
    return 0.0 if wrong == 0 else np.inf


def full_contact_error(problem: Problem) -> float:
    """Return the relative error of the pressure field where all points touch: of S and of storing
    heights and pressures in the working precision."""
    return float(
        np.linalg.norm([problem.rounding / problem.p0, _epsilon(problem), problem.body.error])
    )
