"""Where a solver starts at a load: at the solution of the load before, at a stored gap, at one from
coarser grids, or at that of a flat plane."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..certificate.criterion import StoppingCriterion
from ..solvers import solver_class
from .branches import goes_on
from .drive import certificate_of
from .nested import cold_gap, roughly_solved, undeformed_gap
from .target import Target

if TYPE_CHECKING:
    from ..certificate.certificate import Certificate
    from ..operators.problem import Problem
    from ..scene import SolverTable
    from ..solvers.base import Solver
    from .grid_errors import CoarseContact
    from .load import Load
    from .working_surface import WorkingSurface

# A load starts from the one before if it is larger or smaller by less than these factors, else from
# coarser grids. Not round numbers, because p* has rounding errors.
WARM_UP = 1.45
WARM_DOWN = 1.26
# A start with more than so many times the energy of an undeformed body is replaced by the latter.
# Rough strips have up to 400 times, and start better so than undeformed; flat tops have 80,000
# times and more at loads that the iterations would never solve.
WORSE_THAN_UNDEFORMED = 1e4
# Residual, over that of its start, of the contact without attraction from which one with it starts
WITHOUT_ATTRACTION = 0.02


class Start(NamedTuple):
    """A solver that is ready to iterate at a load.

    Attributes
    ----------
    solver : Solver
        At the starting gap and its pressure. It counts iterations and FFT pairs from this start on.
    criterion : StoppingCriterion
        The accuracy that the load has to reach, and the precision of its certificate.
    pairs : float
        FFT pairs that the start took, apart from those that the solver counts.
    coarser : list of CoarseContact
        The contacts on coarser grids; empty with an attraction, which these do not have.
    certificate : Certificate or None
        Certificate of the starting gap if that may be the solution; the solver then has to begin at
        it.
    """

    solver: Solver
    criterion: StoppingCriterion
    pairs: float
    coarser: Sequence[CoarseContact] = ()
    certificate: Certificate | None = None


class Starter:
    """Makes the solver of a sweep, starts it at each load, and keeps it from load to load.

    Parameters
    ----------
    settings : scene.SolverTable
        The table [solver] of a scene: name and options of the solver, and the accuracy.
    duality : bool
        Whether certificates compute the duality gap.

    Attributes
    ----------
    solver_class : type of Solver
        The class of the solver.
    solver : Solver or None
        The solver, at the solution of the load before; None before the first load, and after
        `forget`.
    criterion : StoppingCriterion
        The accuracy that every load has to reach.
    """

    def __init__(self, settings: SolverTable, duality: bool = False):
        self.settings = settings
        self.solver_class = solver_class(settings.name)
        self.solver: Solver | None = None
        self.criterion = StoppingCriterion(
            settings.accuracy, settings.residual, settings.max_iterations, duality=duality
        )

    @property
    def nests(self) -> bool:
        """Whether contacts without a previous solution are first solved on coarser grids."""
        return self.settings.nested == "auto" or self.settings.nested

    def forget(self) -> None:
        """Drop the solver and its memory: the next load cannot start from the last solution."""
        self.solver = None

    @property
    def gap(self) -> np.ndarray:
        """The solver's array of the gap at the load before, local slab; there must be a solver."""
        assert self.solver is not None  # there is one
        return self.solver.g

    def start(self, working: WorkingSurface, load: Load, gap: np.ndarray | None = None) -> Start:
        """Start the solver at a load, and make the solver if there is none.

        In this order: at `gap`; at the solution of the load before (see `follows`); undeformed, if
        an attraction acts without a positive load; with a closed gap, if the load asks for that; or
        at the solution on coarser grids. Collective.

        Parameters
        ----------
        working : WorkingSurface
            The surface in the precision of the solver.
        load : Load
            The load. Its target changes: coarser grids already use it.
        gap : ndarray, optional
            A gap to start from, local slab of the grid. It is copied.

        Returns
        -------
        Start
            The solver, which the next start uses again, and its criterion.

        Raises
        ------
        Stopped
            On all ranks, if a signal asks the run to stop while coarser grids are solved.
        """
        if gap is not None:
            return self._start_at(working, load, gap)
        if self.follows(working, load):
            return self._continue(working, load)
        if working.model.attraction is not None and load.p0 <= 0:
            return self._start_undeformed(working, load)
        if load.target.from_full_contact:
            return self._start_at(working, load, 0.0)
        return self._start_cold(working, load)

    # -- the ways to start

    def follows(self, working: WorkingSurface, load: Load) -> bool:
        """Return whether a load starts from the solution of the load before.

        It does if the two are close; on retraction always, if the load does not rise. It does not
        without a solver, nor if it seeks the smallest load that closes the gap.

        Parameters
        ----------
        working : WorkingSurface
            The surface.
        load : Load
            The load, whose mean pressure (or a first guess) must be known.

        Returns
        -------
        bool
            The same on all ranks.
        """
        if self.solver is None or load.closes:
            return False
        before = self.solver.p0
        if working.model.attraction is not None:
            if not goes_on(working.model.branch, load.p0, before):
                return False
            if working.model.retracts:  # however far: the state before is part of what is asked
                return True
        return 1 / WARM_DOWN < load.p0 / before < WARM_UP

    def _continue(self, working: WorkingSurface, load: Load) -> Start:
        """Continue the solver at the load's p0, from its present solution, with its counts at 0."""
        solver = self.solver
        assert solver is not None
        solver.reset_counts()
        solver.continue_at(load.p0)
        return Start(solver, self._criterion_for(working, load, solver), 0.0)

    def _start_at(self, working: WorkingSurface, load: Load, gap: np.ndarray | float) -> Start:
        """Start from a gap, which is copied; a number stands for the same gap everywhere."""
        problem = self._problem_to_start(working, load)
        memory = working.memory_for_gap(problem, self.solver)
        if memory is None:
            memory = working.surface.grid.empty(working.dtype)
        memory[...] = gap
        solver, criterion = self._solver_for(working, load, problem, memory)
        if problem.attraction is not None:
            return Start(solver, criterion, _lay_down(solver, criterion, memory))
        certificate = _certified(solver, criterion, memory)
        return Start(solver, criterion, certificate.pairs, certificate=certificate)

    def _start_cold(self, working: WorkingSurface, load: Load) -> Start:
        """Start from the solution on the next coarser grid, or from a flat plane without nesting.

        With an attraction the start is the contact without it. If the start has far too much energy
        the undeformed body replaces it.
        """
        problem = self._problem_to_start(working, load)
        memory = working.memory_for_gap(problem, self.solver)
        nested = working.nested()
        nests = nested is not None
        if nested is None:
            gap = cold_gap(problem)
            pairs = 0.0
            coarser: list[CoarseContact] = []
        else:
            bare = replace(problem, attraction=None)
            gap, pairs, coarser = nested.start(bare, self._make, load.target, memory)
            if problem.attraction is not None and nested.is_coarsest:
                gap, more = self._without_attraction(bare, gap)
                pairs += more
        del nested  # in low memory the transforms of the coarser grids go with it
        solver, criterion = self._solver_for(working, load, problem, gap)
        pairs += _lay_down(solver, criterion, gap)
        heights_are_there = working.surface.h is not None
        if nests and heights_are_there and _is_worse_than_undeformed(solver):
            pairs += _lay_down(solver, criterion, working.surface.gap)
        return Start(solver, criterion, pairs, [] if problem.attraction else coarser)

    def _start_undeformed(self, working: WorkingSurface, load: Load) -> Start:
        """Start from the undeformed body, which touches the highest point only."""
        problem = self._problem_to_start(working, load)
        gap = undeformed_gap(problem)
        solver, criterion = self._solver_for(working, load, problem, gap)
        return Start(solver, criterion, _lay_down(solver, criterion, gap))

    # -- their steps

    def _without_attraction(self, problem: Problem, gap: np.ndarray) -> tuple[np.ndarray, float]:
        """Solve the contact without attraction roughly, on a grid without a coarser one.

        `problem` has no attraction. A solver of its own starts from `gap`; neither `gap` nor
        `self.solver` is changed. Returns the new gap, in new memory, and the FFT pairs that it
        took. Raises Stopped on all ranks if a signal asks the run to stop. Collective.
        """
        solver = roughly_solved(problem, self._make, gap, WITHOUT_ATTRACTION, Target(problem.p0))
        return solver.g, solver.pairs

    def _problem_to_start(self, working: WorkingSurface, load: Load) -> Problem:
        """Return the problem at the load with stored heights; in low memory drop the solver."""
        if working.solver_makes_room:
            self.solver = None
        return replace(working.problem_to_start(load.p0), spring=load.target.spring)

    def _make(self, problem: Problem, gap: np.ndarray | None = None) -> Solver:
        """Make a solver; `gap` becomes its array of the gap (new memory without it)."""
        return self.solver_class(problem, self.settings.options, gap)

    def _solver_for(
        self, working: WorkingSurface, load: Load, problem: Problem, gap: np.ndarray
    ) -> tuple[Solver, StoppingCriterion]:
        """Return the solver with its counts at 0 and its p0 at the load, and its criterion.

        Makes the solver if there is none, with `gap` as its array; an existing one keeps its own.
        Either way the caller has to start it at the gap (`_lay_down`). The target begins on the
        finest grid. In low memory the heights are freed.
        """
        p0 = load.target.begin()
        problem = working.problem_to_iterate(replace(problem, p0=p0))
        if self.solver is None:
            self.solver = self._make(problem, gap)
        self.solver.reset_counts()
        self.solver.p0 = problem.p0
        return self.solver, self._criterion_for(working, load, self.solver)

    def _criterion_for(
        self, working: WorkingSurface, load: Load, solver: Solver
    ) -> StoppingCriterion:
        """Return the criterion of a load; its certificate is in double precision if rounding errors
        would spoil one in the working precision."""
        double = working.rounding_counts(solver.problem_now, self.criterion)
        dtype = np.dtype(np.float64) if double else working.dtype
        return replace(
            self.criterion,
            certificate_dtype=dtype.type,
            in_turn=working.certifies_in_turn and dtype != working.dtype,
            closes=load.closes,
        )


def _lay_down(solver: Solver, criterion: StoppingCriterion, gap: np.ndarray) -> float:
    """Start a solver at a gap; return the FFT pairs that the solver does not count itself.

    If the certificate is in double precision, so is the first pressure: its rounding errors would
    stay to the end, because later only changes are added to it. Collective.
    """
    if criterion.certificate_dtype == solver.problem.dtype:
        solver.start(gap)
        return 0.0
    certificate = _certified(solver, replace(criterion, duality=False), gap)
    solver.begin_at(certificate)
    return certificate.pairs


def _certified(solver: Solver, criterion: StoppingCriterion, gap: np.ndarray) -> Certificate:
    """Certify a starting gap, at which the solver then has to begin. Collective."""
    if gap is not solver.g:
        solver.g[...] = gap
    return certificate_of(solver, criterion)


def _is_worse_than_undeformed(solver: Solver) -> bool:
    """Return whether the solver's state has far more energy than a flat body that just touches.

    This happens at light loads on flat tops, whose edges coarse grids distort more than the load
    does. Always False on a padded grid.
    """
    if solver.grid.padded:
        return False
    undeformed = solver.p_cell * solver.N * solver.problem.root_mean_square
    return 0.5 * solver.uKu > WORSE_THAN_UNDEFORMED * undeformed
