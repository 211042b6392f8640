"""Where a solver starts at a load: the load before, a gap that was stored, coarser grids, or a flat
plane."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..certificate.criterion import StoppingCriterion
from ..solvers import solver_class
from .branches import goes_on
from .drive import certificate_of
from .nested import cold_gap, roughly_solved, undeformed_gap

if TYPE_CHECKING:
    from ..operators.problem import Problem
    from ..scene import SolverTable
    from ..solvers.base import Solver
    from .load import Load
    from .working_surface import WorkingSurface

# A load up to so much larger or smaller starts from the one before, others from coarser grids.
# These are not round numbers, nor are their neighbours: p* has rounding errors.
WARM_UP = 1.45
WARM_DOWN = 1.26
# A start with so many times the energy of an undeformed body is replaced by that: rough strips have
# up to 400 times, and start better than undeformed; flat tops at loads that the iterations never
# solve have 80,000 times and more.
WORSE_THAN_UNDEFORMED = 1e4
# What is left of the residual of the contact without attraction, from which one with it starts
WITHOUT_ATTRACTION = 0.02


class Start(NamedTuple):
    """A solver that is ready to iterate at a load.

    Attributes
    ----------
    solver : Solver
        At the starting gap, with its counts at 0 before that.
    criterion : StoppingCriterion
        What the load has to reach.
    pairs : float
        FFT pairs that the start took beside those that the solver counts.
    """

    solver: Solver
    criterion: StoppingCriterion
    pairs: float


class Starter:
    """Gives the solver of a sweep its start at each load, and keeps it from load to load.

    Parameters
    ----------
    settings : scene.SolverTable
        Name and options of the solver, and what it has to reach.
    duality : bool
        Whether the certificate has to give the duality gap.

    Attributes
    ----------
    solver_class : type of Solver
        What is made.
    solver : Solver or None
        The solver, at the solution of the load before; None before the first load, and after
        `forget`.
    criterion : StoppingCriterion
        What every load has to reach.
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
        """Whether contacts are solved on coarser grids first."""
        return self.settings.nested == "auto" or self.settings.nested

    def forget(self) -> None:
        """Give the solver's memory back: the next load starts afresh."""
        self.solver = None

    @property
    def gap(self) -> np.ndarray:
        """The gap of the load before, local slab of the grid."""
        assert self.solver is not None  # there is one
        return self.solver.g

    def start(self, working: WorkingSurface, load: Load, gap: np.ndarray | None = None) -> Start:
        """Start the solver at a load.

        Collective.

        Parameters
        ----------
        working : WorkingSurface
            The surface in the precision of the solver.
        load : Load
            The load; its search, if it has one, begins on the coarsest grid.
        gap : ndarray, optional
            A gap to start from, local slab of the grid, which is copied.

        Returns
        -------
        Start
            The solver and what it has to reach.

        Raises
        ------
        Stopped
            On all ranks, when the run is to stop while coarser grids are solved.
        """
        if gap is not None:
            return self._start_at(working, load, gap)
        if self.follows(working, load):
            return self._continue(working, load)
        if working.model.attraction is not None and load.p0 <= 0:
            return self._start_undeformed(working, load)
        if load.from_full_contact:
            return self._start_at(working, load, 0.0)
        return self._start_cold(working, load)

    # -- the ways to start

    def follows(self, working: WorkingSurface, load: Load) -> bool:
        """Return whether a load starts from the one before.

        Parameters
        ----------
        working : WorkingSurface
            The surface.
        load : Load
            With its mean pressure.

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
        """Start from the solution of the load before."""
        solver = self.solver
        assert solver is not None
        solver.reset_counts()
        solver.continue_at(load.p0)
        return Start(solver, self._criterion_for(working, load, solver), 0.0)

    def _start_at(self, working: WorkingSurface, load: Load, gap: np.ndarray | float) -> Start:
        """Start from a gap, which is copied; a number: the same everywhere."""
        problem = self._problem_to_start(working, load)
        memory = working.memory_for_gap(problem, self.solver)
        if memory is None:
            memory = working.surface.grid.empty(working.dtype)
        memory[...] = gap
        solver, criterion = self._solver_for(working, load, problem, memory)
        return Start(solver, criterion, _lay_down(solver, criterion, memory))

    def _start_cold(self, working: WorkingSurface, load: Load) -> Start:
        """Start from the solution on the next coarser grid, or from a flat plane."""
        problem = self._problem_to_start(working, load)
        memory = working.memory_for_gap(problem, self.solver)
        nested = working.nested()
        nests = nested is not None
        if nested is None:
            gap = cold_gap(problem)
            pairs = 0.0
        else:
            bare = replace(problem, attraction=None)
            gap, pairs = nested.start(bare, self._make, load.search, memory)
            if problem.attraction is not None and nested.is_coarsest:
                gap, more = self._without_attraction(bare, gap)
                pairs += more
        del nested  # in low memory the transforms of the coarser grids go with it
        solver, criterion = self._solver_for(working, load, problem, gap)
        pairs += _lay_down(solver, criterion, gap)
        heights_are_there = working.surface.h is not None
        if nests and heights_are_there and _is_worse_than_undeformed(solver):
            pairs += _lay_down(solver, criterion, working.surface.gap)
        return Start(solver, criterion, pairs)

    def _start_undeformed(self, working: WorkingSurface, load: Load) -> Start:
        """Start from the undeformed body where it just touches."""
        problem = self._problem_to_start(working, load)
        gap = undeformed_gap(problem)
        solver, criterion = self._solver_for(working, load, problem, gap)
        return Start(solver, criterion, _lay_down(solver, criterion, gap))

    # -- their steps

    def _without_attraction(self, problem: Problem, gap: np.ndarray) -> tuple[np.ndarray, float]:
        """Return the gap of about the contact without attraction, on a grid that has no coarser
        one, and the FFT pairs that it took. The gap that is given is lost."""
        solver = roughly_solved(problem, self._make, gap, WITHOUT_ATTRACTION, None)
        return solver.g, solver.pairs

    def _problem_to_start(self, working: WorkingSurface, load: Load) -> Problem:
        if working.solver_makes_room:
            self.solver = None
        return replace(working.problem_to_start(load.p0), spring=load.spring)

    def _make(self, problem: Problem, gap: np.ndarray | None = None) -> Solver:
        """Make a solver; gap: memory for its gap, which it takes over."""
        return self.solver_class(problem, self.settings.options, gap)

    def _solver_for(
        self, working: WorkingSurface, load: Load, problem: Problem, gap: np.ndarray
    ) -> tuple[Solver, StoppingCriterion]:
        """Return the solver, made if there is none, at the load as it is now, and what it has to
        reach."""
        p0 = load.p0 if load.search is None else load.search.begin()
        problem = working.problem_to_iterate(replace(problem, p0=p0))
        if self.solver is None:
            self.solver = self._make(problem, gap)
        self.solver.reset_counts()
        self.solver.p0 = problem.p0
        return self.solver, self._criterion_for(working, load, self.solver)

    def _criterion_for(
        self, working: WorkingSurface, load: Load, solver: Solver
    ) -> StoppingCriterion:
        """Return what a load has to reach, certified in double precision where rounding errors
        would count."""
        double = working.rounding_counts(solver.problem_now, self.criterion)
        dtype = np.dtype(np.float64) if double else working.dtype
        return replace(
            self.criterion,
            certificate_dtype=dtype.type,
            in_turn=working.certifies_in_turn and dtype != working.dtype,
            closes=load.closes,
        )


def _lay_down(solver: Solver, criterion: StoppingCriterion, gap: np.ndarray) -> float:
    """Give a solver a gap; return the FFT pairs that it does not count itself.

    Where the certificate is in double precision, so is the first pressure: its rounding errors
    would stay to the end, because only changes are added to it.
    """
    if criterion.certificate_dtype == solver.problem.dtype:
        solver.start(gap)
        return 0.0
    if gap is not solver.g:
        solver.g[...] = gap
    certificate = certificate_of(solver, replace(criterion, duality=False))
    solver.begin_at(certificate)
    return certificate.pairs


def _is_worse_than_undeformed(solver: Solver) -> bool:
    """Return whether the start has far more energy than a flat body that just touches: at light
    loads on flat tops what coarse grids make of edges is larger than what the load does."""
    if solver.grid.padded:
        return False
    undeformed = solver.p_cell * solver.N * solver.problem.root_mean_square
    return 0.5 * solver.uKu > WORSE_THAN_UNDEFORMED * undeformed
