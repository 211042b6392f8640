"""How many points may be in the wrong set, in contact or out of it.

The error of the area cannot be bounded: on an ordered wall a whole ring of points may change sides
together. It is estimated from the error of the pressure, from the number of points over which this
error is spread, and from the change of pressure that would move each point to the other side.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..kernels.certify import BINS, PER_OCTAVE, count_uncertain, open_moments
from ..parallel.threads import added
from .error_estimates import CALIBRATION, Estimate

if TYPE_CHECKING:
    from ..operators.problem import Problem


def misclassified_points(
    problem: Problem, g: np.ndarray, p: np.ndarray, errors: Estimate, spread: float, contact: float
) -> float:
    """Estimate how many points are in the wrong set, in contact or out of it. Collective.

    A point may change sides if the change of pressure that this takes is not large beside the rms
    error of the pressure. No more points count than the total squared error can move, the easiest
    first. Points in contact and open points change the area in opposite directions, so the larger
    of the two numbers is returned. With a hardness the contact keeps as many points as carry the
    load.

    Parameters
    ----------
    problem : Problem
        At the load of the state.
    g, p : array, local slabs
        Gap and pressure of the state.
    errors : Estimate
        Estimated errors of the state.
    spread : float
        Number of points over which the error of the pressure is spread, see `spread_of`.
    contact : float
        Number of points in contact on all ranks.

    Returns
    -------
    float
        A number of points, not always whole; the same on all ranks.
    """
    mean_square = errors.squares / spread
    tie = CALIBRATION.rounding * problem.rounding
    is_double = problem.dtype == np.float64
    sure = 0.0 if is_double else tie
    squares_outside = errors.squares * _lone_point_factor(problem, contact)
    largest = max(min(mean_square * CALIBRATION.farthest**2, squares_outside), sure**2)
    if largest <= 0:
        return 0.0
    counts = _uncertain_points(problem, g, p, tie if is_double else 0.0, sure, largest, errors.fall)
    inside, outside = counts
    takes = largest * 2.0 ** (-(np.arange(BINS) + 1) / PER_OCTAVE)
    takes[-1] = 0.0
    # the contact grows with the load, about in proportion
    joining_by_load = errors.missing_load * contact

    def changing(points: np.ndarray, by_load: float, squares: float) -> float:
        likely = max(_likely_to_change(problem, points, takes, mean_square, by_load), 0.0)
        spent = np.cumsum((points * takes)[::-1])
        easiest = np.cumsum(points[::-1])
        affordable = np.floor(np.interp(squares, spent, easiest))
        return float(min(likely, affordable))

    leaving = changing(inside, -joining_by_load, errors.squares)
    joining = changing(outside, joining_by_load, squares_outside)
    if problem.hardness is not None:
        carrying = problem.grid.N * problem.p0 / problem.hardness
        leaving = max(min(leaving, np.floor(contact - carrying)), 0.0)
    return float(max(leaving, joining))


def _likely_to_change(
    problem: Problem, points: np.ndarray, takes: np.ndarray, mean_square: float, follow_load: float
) -> float:
    """Return how many points of a histogram will probably change sides, with a margin for scatter.

    In reach are points that take a change of pressure of less than CALIBRATION.reach times the rms
    error of the pressure. With a hardness all of them are expected to change sides, otherwise those
    of one half of this range of pressures, the half with more points. If `follow_load` is larger,
    that number is expected. The root of the expected number is added for scatter. The result is no
    less than CALIBRATION.few, or than all points of the histogram if these are fewer.

    Parameters
    ----------
    problem : Problem
        The contact; only whether it has a hardness is used.
    points : array (BINS,)
        Histogram of the points by `takes`.
    takes : array (BINS,)
        Square of the smallest change of pressure that moves points of each bin to the other side.
    mean_square : float
        Mean square of the error of the pressure over the points that have this error.
    follow_load : float
        Number of points that a correction of the load would move to the other side; below 0 if it
        moves points in the opposite direction.

    Returns
    -------
    float
        A number of points, not always whole.
    """
    near, within = (
        points[takes < mean_square * x**2].sum() for x in (CALIBRATION.reach / 2, CALIBRATION.reach)
    )
    expected = within if problem.hardness is not None else max(near, within - near)
    expected = max(expected, follow_load)
    return max(expected + np.sqrt(expected), min(points.sum(), CALIBRATION.few))


def _lone_point_factor(problem: Problem, contact: float) -> float:
    """Return the factor by which histograms overestimate the squared pressure that closes a gap.

    The histograms of `_uncertain_points` use the compliance of the stiffest wave for open points. A
    single point has a larger one, S00. If it takes over a pressure from n points in contact, this
    moves it by S00 (1 + 1/n) relative to them, and adds (1 + 1/n) times its square to the error.
    The factor is 1 or more; it allows the same error to close more open points.
    """
    grid = problem.grid
    softer = problem.body.point_compliance(grid) * problem.body.scale(grid)
    return max(softer, 1.0) ** 2 * (1 + 1 / max(contact, 1))


def _uncertain_points(
    problem: Problem,
    g: np.ndarray,
    p: np.ndarray,
    tie: float,
    sure: float,
    largest: float,
    fall: float,
) -> np.ndarray:
    """Return histograms (2, BINS) of the points in contact and of open points, over all ranks.

    They are by the square of the change of pressure that moves a point to the other side. For the
    other arguments see kernels/certify.py: count_uncertain. Collective.
    """
    grid = problem.grid
    compliance = 1.0 / problem.body.scale(grid)

    def count(i0: int, i1: int) -> np.ndarray:
        counts = np.zeros((2, BINS))
        inside = (i1 - i0, grid.inside[1])
        count_uncertain(g[i0:i1], p[i0:i1], inside, compliance, tie, sure, largest, fall, counts)
        return counts

    counts = np.sum([np.zeros((2, BINS)), *grid.by_rows(count, grid.inside[0])], axis=0)
    return np.reshape(grid.comm.sum(counts.ravel()), (2, BINS))


def moments_of_open(problem: Problem, g: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Return the sums of p^2 and p^4 over the open points of this rank. Not collective.

    Points that yield count with the pressure beyond the hardness.

    Parameters
    ----------
    problem : Problem
        The contact.
    g, p : array, local slabs
        Gap and pressure of a state.

    Returns
    -------
    array (2,)
        The two sums, on the surface only.
    """
    (rows, points), limit = problem.grid.inside, problem.limit

    def moments(i0: int, i1: int) -> tuple[float, float]:
        return open_moments(g[i0:i1], p[i0:i1], limit, (i1 - i0, points))

    return added(problem.grid.by_rows(moments, rows), 2)


def spread_of(squares: float, fourth: float, contact: float, N: int) -> float:
    """Estimate over how many points the error of the pressure is spread.

    It is taken as spread like the pressure out of contact: (sum p^2)^2/(sum p^4) points, but no
    more than are in contact and no more than are open.

    Parameters
    ----------
    squares, fourth : float
        Sums of p^2 and p^4 over open points, on all ranks.
    contact : float
        Number of points in contact on all ranks.
    N : int
        Number of points of the surface.

    Returns
    -------
    float
        At least 1; 1 as well if no pressure is left out of contact.
    """
    participating = squares**2 / fourth if fourth > 0 else 1.0
    return max(min(participating, contact, N - contact), 1.0)
