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

from ..kernels.certify import BINS, PER_OCTAVE, count_uncertain, open_moments
from ..operators.multilevel import EQUIVALENCE
from ..operators.problem import ROUNDING, self_energy
from ..parallel.threads import added
from .plastic_limits import further_movement

if TYPE_CHECKING:
    from ..operators.multilevel import Multilevel
    from ..operators.problem import Problem


@dataclass(frozen=True)
class Calibration:
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


CALIBRATION = Calibration()


class State(NamedTuple):
    """Sums over all points, and all ranks, of a state at the mean pressure p0.

    open_p, open_pp: of p and p^2 out of contact, less the hardness where a point yields; closed_pp:
    of p^2 in contact; contact: points; yielded: of these; gap: of gaps; uKu: <u, K u>;
    level_sums: what Multilevel.sweep returns of p out of contact.
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


class Estimate(NamedTuple):
    """Relative errors of the mean gap and of the pressure field; attainable: of both, where most of
    it is what no iteration makes smaller, that part, else 0; squares: of the pressure's error,
    summed over points; shift: of the sum of gaps, by the load that is missing or misplaced; fall:
    height by which the body may move further than the contact's stiffness says, because all that is
    elastic yields or opens."""

    gap: float = np.inf
    pressure: float = np.inf
    attainable: tuple[float, float] = (0.0, 0.0)
    squares: float = np.inf
    shift: float = np.nan
    fall: float = 0.0


def estimate(
    problem: Problem, levels: Multilevel, g: np.ndarray, state: State, stability: float = 1.0
) -> Estimate:
    """Return the Estimate of a state, for solver and certificate alike.

    p^ is the pressure in contact, more by as much at each point as makes up for what is left out of
    contact. Rounding errors of the working precision are those of the heights, which are
    independent from point to point, and those of the pressure, as a load that is wrong by as much.

    With an attraction p0 is what the wall bears, and all this is about the contact under the same
    attraction, frozen. The equilibrium is 1/stability as far away (stability.py).
    """
    p0, N, body = state.p0, problem.grid.N, problem.body
    contact, gap, closed_pp = state.contact - state.yielded, state.gap, state.closed_pp
    if contact == 0 and state.yielded > 0:
        contact = 1.0  # the point that is to balance the load
    if not (contact > 0 and closed_pp > 0 and isfinite(state.open_pp + gap + state.uKu)):
        return Estimate()
    if not (stability > 0 and p0 > 0):
        return Estimate()
    compliance, share = 1.0 / body.scale(problem.grid), contact / N
    residual, test, product = levels.test_products(
        state.open_p, state.open_pp, contact, *state.level_sums
    )
    opened = (N - state.contact) / max(N - contact, 1)  # not yielded, of what is free
    e = sqrt(EQUIVALENCE * compliance * residual) / stability
    response = sqrt(compliance * test) / share
    squares = (CALIBRATION.pressure * e) ** 2 * body.typical(problem.grid)

    eps = ROUNDING * float(np.finfo(problem.dtype).eps)
    relative = sqrt(squares / closed_pp)
    floor = hypot(problem.rounding / sqrt(closed_pp / contact), eps, body.error) / stability
    pressure, floor = hypot(relative, floor), floor if relative < floor else 0.0
    if state.contact == N:  # nothing is open
        return Estimate(0.0, pressure, (0.0, floor), squares, 0.0)
    shift = compliance * product / share / stability
    norm = sqrt(max(state.uKu, 0.0))
    first = inf  # where the load is not the same at every point this says nothing of the gap
    if problem.attraction is None:
        first = e * ((norm + e) / p0 + self_energy(problem.grid))
    second = CALIBRATION.unknown * response * e + CALIBRATION.shift * abs(shift)
    if state.yielded:
        first += (second - first) * (1 - p0 / (problem.hardness or inf))
    further = further_movement(problem, N * p0, g, gap, state.contact, e, response)
    wrong = min(first, second) + further
    wide = sqrt(N - contact)
    last = CALIBRATION.corner * sqrt(N) * wide * max(1, wide / 2)  # m points: sqrt(m)/2
    loaded = CALIBRATION.loaded * (response**2 + compliance * N)
    least = body.error * p0 * min(loaded, last)
    least += eps * (p0 * response**2 + gap) + problem.rounding * (N - contact)
    least /= stability
    attainable = relative_error(least, gap) if wrong < least else 0.0, floor
    return Estimate(
        relative_error(wrong + least, gap),
        pressure,
        attainable,
        squares,
        opened * shift,
        further / (N - state.contact),
    )


def relative_error(wrong: float, value: float) -> float:
    """Return the error of a number relative to the true one, from which it is `wrong` away at
    most."""
    return float(wrong / (value - wrong)) if wrong < value else (0.0 if wrong == 0 else np.inf)


def misclassified_points(
    problem: Problem, g: np.ndarray, p: np.ndarray, errors: Estimate, spread: float, contact: float
) -> float:
    """Count how many points may be in the wrong set, in contact or out of it. Collective.

    Those whose change takes little beside the rms error of the pressure, no more than it takes to
    use the squares of that error up, the easiest first. Points in contact and out of it are counted
    apart: they change the area in opposite ways. With a hardness no fewer points touch than carry
    the load.

    Parameters
    ----------
    problem : Problem
        At the load of the state.
    g, p : array, local slabs
        Gap and pressure of the state.
    errors : Estimate
        Of the state.
    spread : float
        Number of points that the error of the pressure is spread over.
    contact : float
        Number of points in contact.

    Returns
    -------
    float
        Number of points, whole.
    """
    squares = errors.squares
    mean_square, tie = squares / spread, CALIBRATION.rounding * problem.rounding
    double = problem.dtype == np.float64
    sure = 0.0 if double else tie
    largest = max(min(mean_square * CALIBRATION.farthest**2, squares), sure**2)
    if largest <= 0:
        return 0.0
    grid = problem.grid
    limits = 1.0 / problem.body.scale(grid), tie if double else 0.0, sure, largest, errors.fall

    def count(i0: int, i1: int) -> np.ndarray:
        counts, inside = np.zeros((2, BINS)), (i1 - i0, grid.inside[1])
        count_uncertain(g[i0:i1], p[i0:i1], inside, *limits, counts)
        return counts

    counts = np.sum([np.zeros((2, BINS)), *grid.by_rows(count, grid.inside[0])], axis=0)
    takes = largest * 2.0 ** (-(np.arange(BINS) + 1) / PER_OCTAVE)
    takes[-1] = 0.0
    wrong, reach = 0.0, CALIBRATION.reach
    leaving = inf
    if problem.hardness is not None:
        leaving = np.floor(contact - grid.N * problem.p0 / problem.hardness)
    counts = np.reshape(grid.comm.sum(counts.ravel()), (2, BINS))
    for points, most_points in zip(counts, (leaving, inf), strict=True):
        near, far = (points[takes < mean_square * x**2].sum() for x in (reach / 2, reach))
        most = max(near, far - near)
        likely = max(most + np.sqrt(most), min(points.sum(), CALIBRATION.few))
        spent, easiest = np.cumsum((points * takes)[::-1]), np.cumsum(points[::-1])
        affordable = np.floor(np.interp(squares, spent, easiest))
        wrong = max(wrong, min(likely, affordable, most_points))
    return float(wrong)


def moments_of_open(problem: Problem, g: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Return the sums of p^2 and p^4 off contact, less the hardness where a point yields, on this
    rank."""
    (rows, points), limit = problem.grid.inside, problem.limit

    def moments(i0: int, i1: int) -> tuple[float, float]:
        return open_moments(g[i0:i1], p[i0:i1], limit, (i1 - i0, points))

    return added(problem.grid.by_rows(moments, rows), 2)


def spread_of(squares: float, fourth: float, contact: float, N: int) -> float:
    """Return the number of points that the error of the pressure is spread over, as what is left
    out of contact is (sums of p^2 and p^4); no more than are in contact, or out of it."""
    return max(min(squares**2 / fourth if fourth > 0 else 1.0, contact, N - contact), 1.0)


def full_contact_error(problem: Problem) -> float:
    """Return the relative error of the pressure field where all points touch: of S and of storing
    heights and pressures in the working precision."""
    eps = ROUNDING * float(np.finfo(problem.dtype).eps)
    return float(np.linalg.norm([problem.rounding / problem.p0, eps, problem.body.error]))
