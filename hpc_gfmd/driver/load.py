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


class HeightStatistics(NamedTuple):
    """Of the heights of a grid. points; highest: those as high as the highest peak, which touch at
    any load; top: mean gap where it just touches, over the unit of slopes; lowest: gap there, which
    is not 0 on a coarse grid; steepness: rms slope between neighbours in a row."""

    points: int
    highest: int
    top: float
    lowest: float
    steepness: float

    @classmethod
    def of(cls, grid: Grid, h: np.ndarray) -> HeightStatistics:
        """Measure the heights h: this rank's slab, in the problem's unit. Collective."""
        lowest = grid.comm.min([float(h.min(initial=np.inf))])[0]
        squares = sum(float(np.square(row[1:] - row[:-1]).sum(dtype=float)) for row in h)
        total, squares = grid.comm.sum([h.sum(dtype=float), squares])
        top = float(total / grid.N - lowest)
        equal = h <= lowest + 64 * float(np.finfo(h.dtype).eps) * top  # but for rounding errors
        highest = int(grid.comm.sum([np.count_nonzero(equal)])[0])
        steepness = float(np.sqrt(squares / grid.N) * grid.a / grid.spacings[1])
        return cls(grid.N, highest, top * grid.a, float(lowest) * grid.a, steepness)


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
        return found is None or solver.expected_area(found) < accuracy

    def learn(self, solver: Solver, certificate: Certificate) -> float:
        """Learn what the certificate finds; returns what is missed, and its error, over the
        tolerance: below 1 the target is met."""
        return 0.0

    def correct(self, solver: Solver, certificate: Certificate, solved: bool) -> bool:
        """Change the load of the solver where the certificate finds that it is wrong; returns
        whether. solved: whether the solution is as accurate as asked."""
        return False
