"""How much further a body may move if its elastic contact can take little more load: equations (10)
and (11) in docs/method.md.

With a hardness H the contact carries between H times the yielded points and H times all points in
contact. Where the load is close to either limit, a small error of the pressure stands for a large
one of the gap: the elastic points yield, and the body comes down onto the next points.

The linear estimate is the minimum of e^2/(2 t) + t R^2/2 + e R c over t, at t = e/R, with e = |p^ -
p|_S and R = |v|_S. But a pressure q = p^ + t v <= H allows no more than

    t n <= room = H (points in contact) - N p0,

n being the number of open points, and on the other side t n <= carried = N p0 - H (yielded points).
Beyond that, q may use points that the body meets when it moves by a height x, which costs at most x
H for each of the m(x) open points with a gap up to x (or dents as deep). With t(x) = (room + H
m(x))/n the gaps may be wrong by

    min over x of   x H m(x)/t(x) + max(e - t(x) R, 0)^2/(2 t(x))

more than the linear estimate says. `further_movement` returns this, the larger one of both sides.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..kernels.certify import BINS, PER_OCTAVE, count_heights

if TYPE_CHECKING:
    from ..operators.problem import Problem


def further_movement(
    problem: Problem,
    load: float,
    g: np.ndarray,
    gap: float,
    contact: float,
    e: float,
    response: float,
) -> float:
    """Return the error of the sum of gaps that yielding adds to the linear estimate. Collective.

    load: N times the wall's mean pressure; gap: sum over open points; contact: points, < N; e: |p^
    - p|_S; response: |v|_S, v lowering open points by 1. A bound if `e` is one; 0 without a
    hardness.
    """
    if not problem.yields:
        return 0.0
    n_open = problem.grid.N - contact
    largest = gap / n_open
    touching, dented, near_open, near_dents = _counts_near_contact(problem, g, largest)
    heights = largest * 2.0 ** (-np.arange(BINS) / PER_OCTAVE)
    movements = []
    for movable, points in (
        (problem.hardness * touching - load, near_open),
        (load - problem.hardness * dented, near_dents),
    ):
        if movable * response >= e * n_open:
            continue
        met = np.append(0.0, problem.hardness * np.cumsum(points[::-1]))
        x = np.append(0.0, heights[::-1])
        t = (max(movable, 0.0) + met) / n_open
        beyond = np.maximum(e - t * response, 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            bound = np.where(t > 0, x * met / t + beyond**2 / (2 * t), np.inf)
        movements.append(float(bound.min()))
    return max(movements, default=0.0)


def _counts_near_contact(
    problem: Problem, g: np.ndarray, largest: float
) -> tuple[float, float, np.ndarray, np.ndarray]:
    """Count points with g <= 0, g < 0, and open points and dents (BINS,) by size, down to largest
    2^(-(k + 1)/PER_OCTAVE). Collective.
    """
    grid = problem.grid
    points = grid.inside[1]

    def count(i0: int, i1: int) -> np.ndarray:
        counts = np.zeros((2, BINS + 1))
        count_heights(g[i0:i1], (i1 - i0, points), largest, counts)
        return counts

    local = np.sum([np.zeros((2, BINS + 1)), *grid.by_rows(count, grid.inside[0])], axis=0)
    counts = np.reshape(grid.comm.sum(local.ravel()), (2, BINS + 1))
    return counts[0, BINS], counts[1, BINS], counts[0, :BINS], counts[1, :BINS]
