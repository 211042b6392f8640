"""How many points may be in the wrong set, in contact or out of it.

The area cannot be bounded, because a whole ring of points may change sides together on an ordered
wall. What is known is how much error the pressure has, how it is spread, and what it takes to move
each point to the other side.
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
    """Return how many points may be in the wrong set, in contact or out of it. Collective.

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
    mean_square = errors.squares / spread
    tie = CALIBRATION.rounding * problem.rounding
    is_double = problem.dtype == np.float64
    sure = 0.0 if is_double else tie
    squares_outside = errors.squares * _square_of_lone_point(problem, contact)
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
    """Return how many points of a histogram are likely to change sides.

    With a hardness all within reach count, otherwise one half of the range, the one with more. They
    are no fewer than those that follow the load which is missing (below 0: the other way).
    """
    near, within = (
        points[takes < mean_square * x**2].sum() for x in (CALIBRATION.reach / 2, CALIBRATION.reach)
    )
    expected = within if problem.hardness is not None else max(near, within - near)
    expected = max(expected, follow_load)
    return max(expected + np.sqrt(expected), min(points.sum(), CALIBRATION.few))


def _square_of_lone_point(problem: Problem, contact: float) -> float:
    """Return by how much the square of what an open point takes to touch may be less than a
    histogram says, which takes the compliance of the stiffest wave.

    A point among open ones has a compliance of its own, S00. A pressure that it takes over from n
    points in contact moves it by S00 (1 + 1/n) against them, and adds (1 + 1/n) of its square to
    the error.
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
    """Return histograms of the points in contact and out of it, (2, BINS), by the square of what
    their change takes (kernels/certify.py: count_uncertain). Collective."""
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
    """Return the sums of p^2 and p^4 out of contact on this rank; where a point yields, of the
    pressure beyond the hardness.

    Parameters
    ----------
    problem : Problem
        The contact.
    g, p : array, local slabs
        Gap and pressure of a state.

    Returns
    -------
    array (2,)
    """
    (rows, points), limit = problem.grid.inside, problem.limit

    def moments(i0: int, i1: int) -> tuple[float, float]:
        return open_moments(g[i0:i1], p[i0:i1], limit, (i1 - i0, points))

    return added(problem.grid.by_rows(moments, rows), 2)


def spread_of(squares: float, fourth: float, contact: float, N: int) -> float:
    """Return the number of points that the error of the pressure is spread over, as what is left
    out of contact is; no more than are in contact, or out of it.

    Parameters
    ----------
    squares, fourth : float
        Sums of p^2 and p^4 out of contact, on all ranks.
    contact : float
        Number of points in contact.
    N : int
        Number of points of the surface.

    Returns
    -------
    float
        At least 1.
    """
    participating = squares**2 / fourth if fourth > 0 else 1.0
    return max(min(participating, contact, N - contact), 1.0)
