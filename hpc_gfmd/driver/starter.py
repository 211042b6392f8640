"""Where a solver starts at a load: the first gap of a list that applies.

The list: a given gap, the one that single precision has reached, the undeformed body under tension,
full contact, and coarser grids (nested.py). Light contacts are solved in a box (box.py) or on few
points (few_points.py). A load close to the one before goes on from that instead.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..certificate.of_pressure import certify_pressure
from ..parallel import interrupt
from ..solvers import solver_class
from .box import Box, Rectangle, solved_in
from .branches import goes_on
from .certifier import Certifier
from .drive import drive
from .few_points import FewPoints
from .nested import Candidate, Nested, cold_gap, roughly_solved, undeformed_gap
from .precision import certificate_dtype
from .target import Target

if TYPE_CHECKING:
    from ..certificate.certificate import Certificate
    from ..certificate.criterion import StoppingCriterion
    from ..certificate.of_pressure import Part
    from ..operators.problem import Problem
    from ..solvers.base import Solver
    from .grid_errors import CoarseContact
    from .working_surface import WorkingSurface

# A load starts from the one before if it is larger or smaller by less than this factor, else from
# coarser grids. Measured on self-affine walls: both take the same pairs at 1.25 and at 1/1.15; from
# the one before a load takes .4 fewer at 1.15, 1.1 more at 1.45 and at 1/1.3. Not a round number,
# because p* has rounding errors.
WARM = 1.21
# Residual, over that of its start, of the contact without attraction from which one with it starts.
# Insensitive: 72 loads of small walls take 20.2, 19.7 and 19.6 pairs at .01, .02 and .04, and reach
# the same equilibria from .005 to .08.
WITHOUT_ATTRACTION = 0.02
# Share of the accuracy that a pressure which the certificate of a part does not compute may take,
# by which its errors grow. Insensitive: nine light loads of rough balls take at most .006.
NEGLECTED = 0.1
# How often few points are solved, each time with those that penetrated before. Chosen: one or two
# are enough on the walls of the campaign.
ROUNDS = 4


class Start(NamedTuple):
    """A solver at the beginning of a load, and what led there."""

    solver: Solver
    certifier: Certifier
    pairs: float  # FFT pairs of the start that the solver does not count
    # contacts on the coarser grids of the start, finest first; none with an attraction
    coarser: Sequence[CoarseContact] = ()
    certificate: Certificate | None = None  # of the starting gap, if it may be the solution


class Starter:
    """Starts the solver at each load on a working surface, and keeps it for the next load.

    `solver`: at the last solution; None before the first load and after `forget`. `kept`: the gap
    that another precision has reached, from which the next load starts; or None.
    """

    def __init__(
        self, working: WorkingSurface, criterion: StoppingCriterion, duality: bool = False
    ):
        self.working = working
        self.settings = working.settings
        self.criterion = criterion
        self.duality = duality
        self.solver_class = solver_class(self.settings.name)
        self.solver: Solver | None = None
        self.kept: np.ndarray | None = None

    def forget(self) -> None:
        """Drop the solver and its memory: the next load cannot start from the last solution."""
        self.solver = None
        self.kept = None

    def gap_in(self, dtype: np.dtype) -> np.ndarray | None:
        """Drop the solver, and return its gap in another precision; None without a solver."""
        gap = None if self.solver is None else self.solver.state.g.astype(dtype)
        self.forget()
        return gap

    # -- from the load before

    def continues(self, target: Target) -> bool:
        """Return whether a load starts from the one before: if close, on retraction or in a cycle
        as `ContactModel.always_continues`; never to close the gap. Its p0 or a guess must be known.
        """
        if self.solver is None or target.closes:
            return False
        before = self.solver.state.p0
        model = self.working.model
        if model.attraction is not None:
            if not goes_on(model.branch, target.p0, before):
                return False
            if model.always_continues:  # the state before is part of what is asked
                return True
        return 1 / WARM < target.p0 / before < WARM

    def continued(self, target: Target) -> Start:
        """Continue the solver at the target's p0, from its present solution, with counts at 0."""
        solver = self.solver
        assert solver is not None
        if self._may_be_few(target):
            problem = self.working.problem(target.p0)
            start = self._start_on_few_points(target, problem, Candidate(solver.state.g))
            if start is not None:
                return start
        solver.reset_counts()
        solver.continue_at(target.p0)
        return Start(solver, self._certifier_for(solver), 0.0)

    # -- from another gap

    def start(self, target: Target, gap: np.ndarray | None = None, in_box: bool = True) -> Start:
        """Start the solver at a load, made if there is none, not from the load before. Collective;
        Stopped on all ranks.

        `gap` (local slab) is copied; in_box: may be solved in a box. The target changes.
        """
        if self.working.saves_memory:
            self.solver = None
        problem = replace(self.working.problem(target.p0), spring=target.spring)
        best = self._candidate(target, problem, gap, in_box)
        if best.gap is None:
            return self._start_in_box(target, problem, best)
        if best.coarser and self._may_be_few(target):
            start = self._start_on_few_points(target, problem, best)
            if start is not None:
                return start
        solver, certifier = self._solver_for(target, problem, best.gap)
        if best.may_be_solved:
            certificate = _certified(solver, certifier, best.gap)
            pairs = best.pairs + certificate.pairs
            return Start(solver, certifier, pairs, best.coarser, certificate)
        pairs = best.pairs + _lay_down(solver, certifier, best.gap)
        return Start(solver, certifier, pairs, best.coarser)

    def _candidate(
        self, target: Target, problem: Problem, gap: np.ndarray | None, in_box: bool
    ) -> Candidate:
        """Return what to start from: a given gap, that of another precision, undeformed (tension),
        0 (full contact), from coarser grids or a plane, with an attraction without it.
        """
        kept = self.kept
        self.kept = None
        memory = self.working.memory_for_gap(problem, self.solver)
        attracts = problem.attraction is not None
        if gap is not None:
            return Candidate(_filled(problem, memory, gap), may_be_solved=not attracts)
        if kept is not None:
            return Candidate(kept, may_be_solved=not attracts)
        if target.p0 <= 0:
            return Candidate(undeformed_gap(problem))
        if target.from_full_contact:
            return Candidate(_filled(problem, memory, 0.0), may_be_solved=True)
        if self.settings.nested:  # "auto" or true
            return self._nested_start(target, problem, memory, in_box)
        return Candidate(cold_gap(problem))

    def _nested_start(
        self, target: Target, problem: Problem, memory: np.ndarray | None, in_box: bool
    ) -> Candidate:
        """Return the solution on coarser grids, with an attraction of the contact without it,
        solved on this grid if there is none. Collective.
        """
        bare = replace(problem, attraction=None)
        grid = problem.grid
        is_open = all(m < n for m, n in zip(grid.nominal, grid.n))
        in_box = in_box and is_open and self._may_be_light(target)
        start = self.working.nested().candidate(bare, self._make, target, memory, in_box)
        if problem.attraction is None:
            may_be_closed = not target.is_sought and target.p0 >= problem.body.full_p_star
            return start._replace(may_be_solved=may_be_closed)
        if start.coarser:
            return start._replace(coarser=())
        assert start.gap is not None  # a box is for contacts without attraction
        rough = roughly_solved(bare, self._make, start.gap, WITHOUT_ATTRACTION, Target(problem.p0))
        return Candidate(rough.state.g, start.pairs + rough.pairs)

    # -- light contacts

    def _may_be_light(self, target: Target) -> bool:
        """Return whether part of the surface may hold the contact: an elastic one, a given load."""
        model = self.working.model
        return not (target.is_sought or model.attraction or model.hardness)

    def _may_be_few(self, target: Target) -> bool:
        """Return whether few points may hold the contact: heights are stored, too."""
        return self._may_be_light(target) and not self.working.saves_memory

    def _start_in_box(self, target: Target, problem: Problem, best: Candidate) -> Start:
        """Start from the contact in a box, or in a larger one if points beyond it penetrate."""
        nested = self.working.nested()
        box = best.box
        pairs = best.pairs
        while box is not None:
            self.forget()  # its memory is needed for the box
            solved = solved_in(box, problem, nested.grids, self._solve_alone)
            gap = problem.grid.empty(problem.dtype)
            solver, certifier = self._solver_for(target, problem, gap)
            certificate, penetrates = self._certified_part(solver, certifier, solved.part)
            pairs += solved.pairs + certificate.pairs
            if not penetrates:
                coarser = solved.coarser_of_surface(certificate.gap_mean, best.coarser)
                return Start(solver, certifier, pairs, coarser, certificate)
            penetrating = Rectangle.of(problem.grid, partial(_penetrates, solver))
            touching = box.touching.joined(penetrating)
            box = Box.around(touching, problem.grid, nested.grids, problem.grid.comm)
        self.forget()
        on_whole = self.start(target, in_box=False)
        return on_whole._replace(pairs=pairs + on_whole.pairs)

    def _start_on_few_points(
        self, target: Target, problem: Problem, best: Candidate
    ) -> Start | None:
        """Start from the contact on few points, again with those that penetrate; None if more than
        a few touch."""
        assert best.gap is not None
        part = FewPoints.solved(problem, best.gap)
        if part is None:
            return None
        solver, certifier = self._solver_for(target, problem, best.gap)
        pairs = best.pairs
        for _ in range(ROUNDS):
            certificate, penetrates = self._certified_part(solver, certifier, part)
            pairs += certificate.pairs
            if not penetrates:
                return Start(solver, certifier, pairs, best.coarser, certificate)
            part = FewPoints.solved(problem, solver.state.g)
            if part is None:
                break
        certificate = _certified(solver, certifier, solver.state.g)
        return Start(solver, certifier, pairs + certificate.pairs, best.coarser, certificate)

    def _certified_part(
        self, solver: Solver, certifier: Certifier, part: Part
    ) -> tuple[Certificate, bool]:
        """Set the solver's state to the contact of a part of the surface; return its certificate,
        and whether points beyond the part penetrate. Collective.
        """
        grid = solver.grid
        certificate, neglected = certify_pressure(
            solver.problem_now,
            part,
            solver.state,
            solver.levels,
            certifier.dtype,
            certifier.duality,
        )

        def penetrate(i0: int, i1: int) -> bool:
            return bool(_penetrates(solver, i0, i1).any())

        penetrates = bool(grid.comm.max([any(grid.by_rows(penetrate, grid.inside[0]))])[0])
        if not penetrates and neglected > NEGLECTED * self.criterion.tolerance:
            again = _certified(solver, certifier, solver.state.g)
            certificate = replace(again, pairs=certificate.pairs + again.pairs)
        return certificate, penetrates

    def _solve_alone(self, problem: Problem) -> tuple[Solver, float, Sequence[CoarseContact]]:
        """Solve a contact on a grid of its own, as accurately as asked."""
        target = Target(problem.p0)
        nested = Nested(problem.grid, problem.dtype)
        start = nested.candidate(problem, self._make, target)
        assert start.gap is not None  # no box is asked for
        solver = self._make(problem, start.gap)
        certifier = self._certifier_for(solver)
        criterion = self.criterion
        if criterion.residual is not None:  # of the pressure over that of the whole surface
            share = np.sqrt(problem.grid.N / self.working.surface.grid.N)
            criterion = replace(criterion, residual=criterion.residual * share)
        pairs = start.pairs + _lay_down(solver, certifier, start.gap)
        outcome = drive(
            solver,
            criterion,
            lambda *_: interrupt.check(problem.grid.comm),
            target,
            certifier=certifier,
        )
        return solver, pairs + solver.pairs + outcome.pairs, start.coarser

    # -- their steps

    def _make(self, problem: Problem, gap: np.ndarray | None = None) -> Solver:
        """Make a solver; `gap` becomes its array of the gap (new memory without it)."""
        return self.solver_class(problem, self.settings.options, gap)

    def _solver_for(
        self, target: Target, problem: Problem, gap: np.ndarray
    ) -> tuple[Solver, Certifier]:
        """Return the solver at the target's p0, with counts at 0 and `gap` as its array if new, and
        its certifier. The caller has to lay it down at the gap; in low memory the heights are
        freed.
        """
        p0 = target.begin()
        problem = self.working.problem_to_iterate(replace(problem, p0=p0))
        if self.solver is None:
            self.solver = self._make(problem, gap)
        if self.solver.problem.spring != problem.spring:  # a search has made it stiffer
            self.solver.hold(problem.spring)
        self.solver.reset_counts()
        self.solver.state.p0 = problem.p0
        return self.solver, self._certifier_for(self.solver)

    def _certifier_for(self, solver: Solver) -> Certifier:
        """Return what certifies a load; in double if rounding would spoil its certificate."""
        working = self.working
        dtype = certificate_dtype(working, solver.problem_now)
        in_turn = working.saves_memory and dtype != working.dtype
        return Certifier(dtype, self.duality, in_turn)


def _filled(problem: Problem, memory: np.ndarray | None, gap: np.ndarray | float) -> np.ndarray:
    """Return `memory`, or a new array without it, filled with a gap."""
    memory = problem.grid.empty(problem.dtype) if memory is None else memory
    memory[...] = gap
    return memory


def _lay_down(solver: Solver, certifier: Certifier, gap: np.ndarray) -> float:
    """Start a solver at a gap; return FFT pairs that it does not count. Collective. The first
    pressure is in the certificate's precision: its rounding errors stay.
    """
    if certifier.dtype == solver.problem.dtype:
        solver.start(gap)
        return 0.0
    certificate = _certified(solver, replace(certifier, duality=False), gap)
    solver.restart()
    return certificate.pairs


def _certified(solver: Solver, certifier: Certifier, gap: np.ndarray) -> Certificate:
    """Certify a starting gap, at which the solver then has to begin. Collective."""
    if gap is not solver.state.g:
        solver.state.g[...] = gap
    return certifier.certify(solver)


def _penetrates(solver: Solver, i0: int, i1: int) -> np.ndarray:
    """Return which points of some local rows of the surface penetrate the wall."""
    return solver.state.g[i0:i1, : solver.grid.inside[1]] < 0
