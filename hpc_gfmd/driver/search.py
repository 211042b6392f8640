"""What the iterations ask a search for a load."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..certificate.certificate import Certificate
    from ..operators.problem import Problem
    from ..parallel.comm import Comm
    from ..solvers.base import Progress, Solver
    from .height_statistics import HeightStatistics


class LoadSearch:
    """A search for the mean pressure of a load that is prescribed by something else.

    The loop (`drive.py`) asks it after every iteration and after every certificate, nested
    iteration on every coarse grid. Numbers are in the program's units, the same on all ranks.

    Attributes
    ----------
    p0 : float
        The present mean pressure.
    note : str or None
        What a user has to know of the load that is found.
    from_full_contact : bool
        Whether the iterations begin with a closed gap.
    spring : float
        Stiffness of the spring through which the body is pressed (operators/problem.py).
    """

    note: str | None = None
    from_full_contact = False
    spring = 0.0

    @property
    def p0(self) -> float:
        """The present mean pressure."""
        raise NotImplementedError

    @property
    def half_area(self) -> float:
        """About half of the relative contact area, which is about p0 where that is small."""
        return self.p0

    @property
    def needs_double(self) -> bool:
        """Whether what is known so far cannot be trusted in single precision."""
        return False

    def measure(self, heights: Callable[[], HeightStatistics]) -> None:
        """Take over what has to be known of the heights in the precision of the solver.

        Collective. heights: finds the statistics of the finest grid.
        """

    def begin(self, problem: Problem | None = None) -> float:
        """Begin on the grid of `problem`, or on the finest one, and return p0. Collective."""
        return self.p0

    def begin_at(self, p0: float) -> None:
        """Begin with this mean pressure, whose solution is about known."""
        raise NotImplementedError

    def agree(self, comm: Comm) -> None:
        """Take over on all ranks what rank 0 has found. Collective."""
        vars(self).update(comm.bcast(vars(self)))

    def near(self, solver: Solver, progress: Progress) -> bool:
        """Return whether p0 is as near as a coarse grid knows it; if not, it may be changed.

        Collective.

        Parameters
        ----------
        solver : Solver
            At the present mean pressure.
        progress : Progress
            Of the solver.

        Returns
        -------
        bool
            The same on all ranks of the grid.
        """
        return True

    def adjust(self, solver: Solver, progress: Progress) -> bool:
        """Change p0 of the solver where it predicts that the target is missed.

        Collective.

        Parameters
        ----------
        solver : Solver
            At the present mean pressure.
        progress : Progress
            Of the solver.

        Returns
        -------
        bool
            Whether p0 has changed.
        """
        return False

    def may_be_met(self, solver: Solver, progress: Progress, accuracy: float) -> bool:
        """Return whether the certificate may find the target met.

        Collective.

        Parameters
        ----------
        solver : Solver
            At the present mean pressure.
        progress : Progress
            Of the solver.
        accuracy : float
            As requested.

        Returns
        -------
        bool
            The same on all ranks.
        """
        return area_may_be_met(solver, progress, accuracy)

    def learn(self, solver: Solver, certificate: Certificate) -> float:
        """Learn from a certificate.

        Collective.

        Parameters
        ----------
        solver : Solver
            At the present mean pressure.
        certificate : Certificate
            Of its gap.

        Returns
        -------
        float
            How far the target is missed over the tolerance; below 1 where it is met.
        """
        return 0.0

    def correct(self, solver: Solver, certificate: Certificate, solved: bool) -> bool:
        """Change p0 of the solver after a certificate that missed the target.

        Collective.

        Parameters
        ----------
        solver : Solver
            At the present mean pressure.
        certificate : Certificate
            Of its gap.
        solved : bool
            Whether the solution at the present p0 is as accurate as asked.

        Returns
        -------
        bool
            Whether p0 has changed.
        """
        return False


def area_may_be_met(solver: Solver, progress: Progress, accuracy: float) -> bool:
    """Return whether the certificate may find the contact area accurate: a look at all points.

    Collective.

    Parameters
    ----------
    solver : Solver
        At a gap.
    progress : Progress
        Of the solver.
    accuracy : float
        As requested.

    Returns
    -------
    bool
        The same on all ranks.
    """
    estimate = progress.estimate
    return estimate is None or solver.expected_area(estimate) < accuracy
