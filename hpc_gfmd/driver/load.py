"""The load of a contact: a mean pressure that is given. A search for it has the same methods, and
begins with the statistics of the heights."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from ..certificate.certificate import Certificate
    from ..operators.problem import Problem
    from ..parallel.comm import Comm
    from ..parallel.grid import Grid
    from ..solvers.base import Progress, Solver


TIE = 64  # rounding errors of the mean gap up to which two peaks are equally high


class HeightStatistics(NamedTuple):
    """Statistics of the heights of one grid, the same on all ranks.

    Attributes
    ----------
    points : int
        Number of points.
    highest : int
        Points as high as the highest peak, which touch at any load.
    alike : int
        Points that the working precision cannot tell from the highest peak, at least `highest`.
    top : float
        Mean gap where the highest peak just touches, over the unit of slopes.
    lowest : float
        Gap at the highest peak there, which is not 0 on a coarse grid that misses the peak.
    steepness : float
        rms slope between neighbours in a row.
    alone : float
        Mean pressure, in the program's unit, up to which a single highest point carries all, at
        least; 0 where several are as high.
    """

    points: int
    highest: int
    alike: int
    top: float
    lowest: float
    steepness: float
    alone: float = 0.0

    @classmethod
    def of(cls, problem: Problem) -> HeightStatistics:
        """Measure the heights of a problem, which are stored. Collective."""
        grid = problem.grid
        h = problem.heights
        lowest = float(grid.comm.min([float(h.min(initial=np.inf))])[0])
        squares = sum(float(np.square(row[1:] - row[:-1]).sum(dtype=float)) for row in h)
        total, squares = grid.comm.sum([h.sum(dtype=float), squares])
        top = float(total / grid.N - lowest)
        # heights near the peak are as accurate in single precision, but not what is computed
        equal, alike = (TIE * float(np.finfo(d).eps) * top for d in (np.float64, h.dtype))
        highest, indistinct, second = 0, 0, np.inf
        for row in h:
            gaps = row[row <= max(lowest + alike, second)]
            above = gaps[gaps > lowest + equal]
            highest += len(gaps) - len(above)
            indistinct += int(np.count_nonzero(gaps <= lowest + alike))
            second = min(second, float(above.min(initial=np.inf)))
        highest, indistinct = map(int, grid.comm.sum([highest, indistinct]))
        second = float(grid.comm.min([second])[0])
        steepness = float(np.sqrt(squares / grid.N) * grid.a / grid.spacings[1])
        alone = 0.0
        if highest == 1 and np.isfinite(second):
            alone = carried_alone(problem, second - lowest)
        return cls(
            grid.N, highest, indistinct, top * grid.a, lowest * grid.a, steepness, alone
        )


def carried_alone(problem: Problem, step: float) -> float:
    """Return the mean pressure that presses a single point down by `step`, at least: to the points
    that are next below it, which go down by less than their mean does not.

    The point goes down by S_00 N p0 relative to the mean of all, others rise by no more than about
    the inverse of the number of points along the shorter axis. Where it yields it carries no more
    than the hardness.
    """
    grid = problem.grid
    compliance = problem.body.point_compliance(grid)
    compliance *= 1 + 1 / min((k for k in grid.n if k > 1), default=2)
    carried = step / compliance
    if problem.hardness is not None:
        carried = min(carried, problem.hardness)
    return carried / grid.N


class GivenLoad:
    """A mean pressure p0, in the program's units, that is given: there is nothing to search for."""

    note: str | None = None  # what is to be said of the load
    from_full_contact = False  # whether the gap is closed to begin with
    closes = False  # whether it is the least load that closes the gap
    given = True  # whether it is known at once
    p_mean: float | None = None  # in the scene's units, where it was given

    def __init__(self, p0: float, p_mean: float | None = None, closes: bool = False):
        self._p0, self.p_mean, self.closes = p0, p_mean, closes

    @property
    def p0(self) -> float:
        """The mean pressure, in the program's units."""
        return self._p0

    @property
    def half_area(self) -> float:
        """About half of the contact area."""
        return self.p0

    def begin(self, problem: Problem | None = None) -> float:
        """Give the load to begin with on a coarse grid, that of `problem`, or on the finest.
        Collective."""
        return self.p0

    def numbers(self) -> dict[str, Any] | None:
        """Give what makes a checkpoint."""
        return None

    def measure(self, heights: HeightStatistics) -> None:
        """Take over the statistics of the finest grid in another precision."""

    def is_beyond(self, precision: np.dtype) -> bool:
        """Whether it takes heights that this precision cannot tell apart."""
        return False

    def agree(self, comm: Comm) -> None:
        """Take over on all ranks what rank 0 has found. Collective."""
        vars(self).update(comm.bcast(vars(self)))

    def near(self, solver: Solver, progress: Progress) -> bool:
        """Tell whether the load on a coarse grid is as near as it need be; if not, it may be
        changed."""
        return True

    def adjust(self, solver: Solver, progress: Progress) -> bool:
        """Change the load of the solver where it predicts that that is wrong; returns whether."""
        return False

    def may_be_met(self, solver: Solver, progress: Progress, accuracy: float) -> bool:
        """Tell whether the certificate may find the area as accurate as asked: a look at all
        points."""
        found = progress.estimate
        return found is None or solver.expected_area(found.squares) < accuracy

    def learn(self, solver: Solver, certificate: Certificate) -> float:
        """Learn what the certificate finds; returns what is missed, and its error, over the
        tolerance: below 1 the target is met."""
        return 0.0

    def correct(self, solver: Solver, certificate: Certificate, solved: bool) -> bool:
        """Change the load of the solver where the certificate finds that it is wrong; returns
        whether. solved: whether the solution is as accurate as asked."""
        return False
