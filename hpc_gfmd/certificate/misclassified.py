"""How many points may be in the wrong set, in contact or out of it: the error of the area.

This cannot be bounded: on an ordered wall a whole ring of points may change sides. It is estimated
from the pressure's error, which (9) in docs/method.md bounds, the number of points over which it is
spread, and the change of pressure that moves each point to the other side.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..kernels.certify import BINS, PER_OCTAVE, changing_points, count_uncertain, open_moments
from ..parallel.threads import added
from .error_estimates import Estimate

if TYPE_CHECKING:
    from ..operators.problem import Problem

# Calibrated with the factors of error_estimates.py.
#
# Points may change sides if this takes a change of pressure below so many times its rms error (over
# the points that have it): 0.5 for random roughness, 1.3 for lattices of equal points. Only the
# half of this range with more points counts: in random roughness both have equally many. Counts of
# n points scatter by sqrt(n), which is added.
REACH = 1.75
# Up to FEW points may change sides if this takes less than so many times that rms error. Chosen:
# from 3 to 24 no area of 200 light loads is wrong, for 3 % of the pairs; at 4 light loads take 7 %
# fewer pairs, and an area of a wall with a hardness is claimed exact with one point wrong.
FARTHEST = 12.0
# Chosen: from .75 to 12 no area of 73 random, ordered and hard walls is wrong, for 4 % of the
# pairs.
FEW = 3.0
# Changes of pressure below so many times its rms rounding error cannot tell on which side a point
# is: of normal errors one in 16,000 is larger. Insensitive: the same pairs and areas from 1 to 16
# on the same walls.
TIED = 4.0
# Ties count as such once the rms error of the pressure is below so many times theirs. Measured: at
# 1 an area of nearly ordered points stagnates, at 11 a second point that just touches is missed.
SETTLED = 4.0
# smallest number in each bin of a histogram, over the largest of all
SMALLEST = np.append(2.0 ** (-np.arange(1, BINS) / PER_OCTAVE), 0.0)


def misclassified_points(
    problem: Problem, g: np.ndarray, p: np.ndarray, errors: Estimate, spread: float, contact: float
) -> float:
    """Estimate how many points are in the wrong set, in contact or out of it. Collective.

    Points may change sides if that takes little beside the rms error of the pressure, spread over
    `spread` points, the easiest first, up to the total squared error. The larger of both directions
    counts; with a hardness as many points as carry the load stay.
    """
    mean_square = errors.squares / spread
    tie = TIED * problem.rounding
    is_double = problem.dtype == np.float64
    sure = 0.0 if is_double else tie
    # larger errors move points that are at a tie now
    at_tie = tie if is_double and mean_square <= (SETTLED * tie) ** 2 else 0.0
    squares_outside = errors.squares * _lone_point_factor(problem, contact)
    largest = max(min(mean_square * FARTHEST**2, squares_outside), sure**2)
    if largest <= 0:
        return 0.0
    counts = _uncertain_points(problem, g, p, at_tie, sure, largest, errors.fall)
    inside, outside = counts
    takes = largest * SMALLEST
    margins = REACH, FEW, problem.yields
    leaving = changing_points(inside, takes, mean_square, -errors.growth, errors.squares, *margins)
    joining = changing_points(outside, takes, mean_square, errors.growth, squares_outside, *margins)
    if problem.yields:
        carrying = problem.grid.N * problem.p0 / problem.hardness
        leaving = max(min(leaving, np.floor(contact - carrying)), 0.0)
    return float(max(leaving, joining))


def _lone_point_factor(problem: Problem, contact: float) -> float:
    """Return by how much histograms (compliance of the stiffest wave) overestimate the squared
    pressure that closes a gap: one point, S00, takes over from n and adds (1 + 1/n) times its
    square.
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
    """Return histograms (2, BINS), in contact and open, by squared change of pressure, as
    kernels/certify.py: count_uncertain. Collective.
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
    """Return sums of p^2 and p^4 over this rank's open points, of p - H where they yield."""
    (rows, points), limit = problem.grid.inside, problem.limit

    def moments(i0: int, i1: int) -> tuple[float, float]:
        return open_moments(g[i0:i1], p[i0:i1], limit, (i1 - i0, points))

    return added(problem.grid.by_rows(moments, rows), 2)


def spread_of(squares: float, fourth: float, contact: float, N: int) -> float:
    """Estimate over how many points the error is spread, like the pressure out of contact: (sum
    p^2)^2/(sum p^4), at most those in contact or open.
    """
    participating = squares**2 / fourth if fourth > 0 else 1.0
    return max(min(participating, contact, N - contact), 1.0)
