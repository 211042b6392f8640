"""The interface between the iterations and a search for a load."""

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
    """A search for the mean pressure p0 of a load that prescribes another quantity.

    That quantity has a target, for example an area. The search changes p0 of a solver while it
    iterates: the loop (`drive.py`) calls it after every iteration and every certificate, nested
    iteration on every coarse grid. Numbers are in the program's units, the same on all ranks.

    Attributes
    ----------
    p0 : float
        The mean pressure at which the solver is, or with which it has to begin.
    note : str or None
        A remark for the user on the load that was found.
    from_full_contact : bool
        Whether the iterations start from a gap of 0 everywhere.
    spring : float
        Stiffness of the spring that presses the body (operators/problem.py); 0 for a dead load.
    touches : bool
        Whether separated bodies cannot meet the target, so that they have to be brought back.
    """

    note: str | None = None
    from_full_contact = False
    spring = 0.0
    touches = False

    @property
    def p0(self) -> float:
        """The present mean pressure."""
        raise NotImplementedError

    @property
    def half_area(self) -> float:
        """An estimate of half the relative contact area; by default p0, right at light loads."""
        return self.p0

    @property
    def needs_double(self) -> bool:
        """Whether the search needs double precision, by what it has found so far."""
        return False

    def measure(self, heights: Callable[[], HeightStatistics]) -> None:
        """Store the statistics of the heights, in the precision of the solver. Collective.

        heights: called without arguments, returns those of the finest grid. By default nothing is
        stored.
        """

    def begin(self, problem: Problem | None = None) -> float:
        """Begin on the grid of `problem`, or on the finest one (None); return p0 to begin with.

        Forgets what was found on the grid before, except p0. Collective.
        """
        return self.p0

    def begin_at(self, p0: float) -> None:
        """Set the mean pressure to begin with, that of an approximate solution."""
        raise NotImplementedError

    def agree(self, comm: Comm) -> None:
        """Copy all attributes of this search from rank 0 to all ranks. Collective."""
        vars(self).update(comm.bcast(vars(self)))

    def near(self, solver: Solver, progress: Progress) -> bool:
        """Return whether p0 is as close as a coarse grid can tell; else perhaps change it.

        Collective on the ranks of this coarse grid.

        Parameters
        ----------
        solver : Solver
            The solver on the coarse grid; gets the new p0 if it changes.
        progress : Progress
            Progress of the solver.

        Returns
        -------
        bool
            Whether the coarse solution may be accepted with regard to p0.
        """
        return True

    def adjust(self, solver: Solver, progress: Progress) -> bool:
        """Change p0 if the converged solution at the present one would probably miss the target.

        Called after every iteration. Collective.

        Parameters
        ----------
        solver : Solver
            The iterating solver; gets the new p0 if it changes.
        progress : Progress
            Progress of the solver.

        Returns
        -------
        bool
            Whether p0, and with it the state of the solver, has changed.
        """
        return False

    def may_be_met(self, solver: Solver, progress: Progress, accuracy: float) -> bool:
        """Return whether a certificate now may find the target met, or tell more of the search.

        Asked once the estimated errors of gap and pressure are small enough. Changes nothing.
        Collective.

        Parameters
        ----------
        solver : Solver
            The iterating solver.
        progress : Progress
            Progress of the solver.
        accuracy : float
            The requested relative accuracy.

        Returns
        -------
        bool
            The same on all ranks.
        """
        return area_may_be_met(solver, progress, accuracy)

    def learn(self, solver: Solver, certificate: Certificate) -> float:
        """Record the certified value at the present p0, and return how far it misses the target.

        Changes the search only, neither p0 nor the solver. Collective.

        Parameters
        ----------
        solver : Solver
            The solver, whose gap was certified.
        certificate : Certificate
            Its certificate.

        Returns
        -------
        float
            Miss over tolerance: below 1 the target is met.
        """
        return 0.0

    def correct(self, solver: Solver, certificate: Certificate, solved: bool) -> bool:
        """Change p0 after a certificate that missed the target; `learn` has recorded it.

        Collective.

        Parameters
        ----------
        solver : Solver
            The solver, whose gap was certified; gets the new p0 if it changes.
        certificate : Certificate
            Its certificate.
        solved : bool
            Whether the solution at the present p0 meets the requested accuracy.

        Returns
        -------
        bool
            Whether p0, and with it the state of the solver, has changed.
        """
        return False

    def bring_back(self, solver: Solver) -> bool:
        """Change p0 of a solver whose bodies are separated, so that they touch again. Collective.

        Called only if the target is one at which they touch (`touches`).

        Parameters
        ----------
        solver : Solver
            The solver; gets the new p0 if it changes.

        Returns
        -------
        bool
            Whether p0 has changed; False if the search gives up.
        """
        return False


def area_may_be_met(solver: Solver, progress: Progress, accuracy: float) -> bool:
    """Return whether a certificate may find the contact area accurate enough.

    This takes a pass over all points. Collective.

    Parameters
    ----------
    solver : Solver
        The solver, at any gap; it is not changed.
    progress : Progress
        Progress of the solver.
    accuracy : float
        Largest relative error of the area.

    Returns
    -------
    bool
        The same on all ranks; True without estimated errors.
    """
    estimate = progress.estimate
    return estimate is None or solver.expected_area(estimate) < accuracy
